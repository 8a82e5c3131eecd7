import { useState } from 'preact/hooks';
import { errorText, post } from '../model/api';
import { draft, openDraft, setDraft, withLines } from '../model/draft';
import { absent, addressOf, daemonName, mayChange, status } from '../model/store';

const LIMIT_MS = 60_000;

interface Step {
    step: 'waiting' | 'on' | 'off' | 'control' | 'done' | 'broken';
    text: string;
    lines: string[];
}

/** What the person has done when the button is pressed. */
const LABELS: Record<Step['step'], string> = {
    waiting: 'Sticks moved, hands off', off: 'The transmitter is off',
    on: 'The transmitter is on and connected', control: 'Go on', done: '', broken: '',
};
const TITLES: Record<Step['step'], string> = {
    waiting: 'Transmitter on', off: 'Off now', on: 'On now', control: 'Gamepad',
    done: 'Recognised', broken: 'Broken off',
};

async function intoDraft(input: string, lines: string[]): Promise<void> {
    const name = daemonName.value;
    await openDraft(name);
    const now = draft.value;
    if (now) {
        setDraft(name, { ...now, text: withLines(now.text, `input.${input}`, lines) });
    }
    location.hash = addressOf('config');
}

interface LearningProps {
    input: string;
    step: Step;
    go: (verb: string) => void;
    busy: boolean;
}

function Learning({ input, step, go, busy }: LearningProps) {
    const ends = step.step === 'done' || step.step === 'broken';
    return (
        <section data-step={step.step}>
            <div role="status">
                <p class="order">{TITLES[step.step]}</p>
                <p class="large">{step.text}</p>
            </div>
            {step.lines.length > 0 && <pre class="commands">{step.lines.join('\n')}</pre>}
            <div class="row">
                {!ends && <button class="main" disabled={busy} onClick={() => go('next')}>
                    {busy ? 'Watching the receiver' : LABELS[step.step]}</button>}
                {step.step === 'done' && step.lines.length > 0
                    && <button class="main" onClick={() => void intoDraft(input, step.lines)}>
                        Put the lines into the draft</button>}
                <button onClick={() => go(ends ? 'start' : 'stop')}>{ends ? 'Once more' : 'Stop'}
                </button>
            </div>
        </section>
    );
}

interface ChoiceProps {
    inputs: string[];
    input: string;
    choose: (input: string) => void;
}

/** Without a daemon the page does not know the inputs: their name is typed. */
function InputChoice({ inputs, input, choose }: ChoiceProps) {
    return (
        <label>Input{' '}
            {inputs.length === 0
                ? <input value={input} onInput={(event) => choose(event.currentTarget.value)} />
                : (
                    <select value={input} onChange={(event) => choose(event.currentTarget.value)}>
                        {inputs.map((one) => <option key={one}>{one}</option>)}
                    </select>
                )}
        </label>
    );
}

export function LearnScreen() {
    const inputs = status.value?.inputs.map((one) => one.name) ?? [];
    const [chosen, choose] = useState('');
    const [step, setStep] = useState<Step | null>(null);
    const [busy, setBusy] = useState(false);
    const [error, setError] = useState('');
    const input = chosen || inputs[0] || '';
    const go = async (verb: string) => {
        setBusy(true);
        setError('');
        try {
            const body = verb === 'start' ? { daemon: daemonName.value, input } : {};
            setStep(await post<Step>(`/api/learn/${verb}`, body, { limit: LIMIT_MS }));
        } catch (failed) {
            setError(errorText(failed));
        } finally {
            setBusy(false);
        }
    };
    return (
        <div class="tool">
            {step ? <Learning input={input} step={step} busy={busy}
                go={(verb) => void go(verb)} />
                : (
                    <section>
                        <p>Many receivers go on sending after they have lost the transmitter. Learn
                            finds out what yours does, and the lines that recognise it.</p>
                        <p><strong>Take the propellers off first, and lift the wheels.</strong> The
                            transmitter will be switched off and on.</p>
                        {!absent.value && (
                            <>
                                <p>A daemon that runs has the port of its receiver. Stop it
                                    first:</p>
                                <pre class="commands">
                                    sudo systemctl stop tribus@{daemonName.value}
                                </pre>
                            </>
                        )}
                        <InputChoice inputs={inputs} input={input} choose={choose} />
                        <div><button class="main" onClick={() => void go('start')}
                            disabled={busy || !mayChange.value || input === ''}>Start</button></div>
                        {!mayChange.value && <p>This browser may only look.</p>}
                    </section>
                )}
            <p class="error" role="alert">{error}</p>
        </div>
    );
}
