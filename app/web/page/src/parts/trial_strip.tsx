// A configuration on trial, on every screen: the seconds, keep and back.
import { useEffect, useState } from 'preact/hooks';
import { errorText } from '../model/api';
import { daemonName, freshness, mayChange } from '../model/store';
import { goBack, keep, runningTrial, trialEnd, type Trial } from '../model/trial';

function useSecondsLeft(until: number): number {
    const [now, setNow] = useState(performance.now());
    useEffect(() => {
        const timer = setInterval(() => setNow(performance.now()), 200);
        return () => clearInterval(timer);
    }, []);
    return Math.max(0, Math.ceil((until - Math.max(now, performance.now())) / 1000));
}

function Running({ trial }: { trial: Trial }) {
    const left = useSecondsLeft(trial.until);
    const [error, setError] = useState('');
    const [busy, setBusy] = useState(false);
    const heard = freshness.value.level === 'live';
    const act = (what: (trial: Trial) => Promise<void>) => {
        setBusy(true);
        setError('');
        void what(trial).catch((failed) => setError(errorText(failed)))
            .finally(() => setBusy(false));
    };
    return (
        <section class="trial" aria-label="Trial" data-testid="trial">
            <p>
                <span class="seconds">On trial{trial.text === null && ', started elsewhere'}:{' '}
                    {left} s left</span>{' '}
                {heard ? 'It goes back by itself.'
                    : 'By this page\'s clock: the board is not heard, and goes back by itself.'}
                {' '}<span class="error" role="alert">{error}</span>
            </p>
            <button class="main" disabled={busy || !mayChange.value} onClick={() => act(keep)}>
                Keep
            </button>
            <button disabled={busy || !mayChange.value} onClick={() => act(goBack)}>Back</button>
        </section>
    );
}

export function TrialStrip() {
    const trial = runningTrial.value;
    const end = trialEnd.value;
    if (trial) {
        return <Running trial={trial} />;
    }
    if (!end || end.daemon !== daemonName.value) {
        return null;
    }
    return (
        <section class="trial over" aria-label="Trial" data-testid="trial">
            <p role="status" class="seconds">{end.text}</p>
            <button onClick={() => { trialEnd.value = null; }}>Close</button>
        </section>
    );
}
