import { useState } from 'preact/hooks';
import { ApiError, errorText, statusOf } from './model/api';
import { pair } from './model/session';
import { me } from './model/store';
import { ThemeButton } from './parts/frame';

const CODE_SIGNS = 8;

/** What a person may type for a code: spaces and small letters too. */
const tidy = (code: string): string => code.toUpperCase().replace(/[^A-Z0-9]/g, '');

function refusal(error: unknown): string {
    const wait = error instanceof ApiError ? error.body.wait_s : undefined;
    const pause = typeof wait === 'number' ? ` The next one counts in ${wait} s.` : '';
    const again = statusOf(error) === 410 ? ' Run sudo tribus pair on the board again.' : '';
    return errorText(error) + pause + again;
}

export function PairScreen() {
    const [code, setCode] = useState('');
    const [name, setName] = useState('');
    const [error, setError] = useState('');
    const [busy, setBusy] = useState(false);
    const send = async (event: Event) => {
        event.preventDefault();
        if (tidy(code).length !== CODE_SIGNS) {
            setError(`A code has ${CODE_SIGNS} letters and digits.`);
            return;
        }
        setBusy(true);
        try {
            await pair(tidy(code), name.trim() || 'browser');
        } catch (failed) {
            setError(refusal(failed));
        } finally {
            setBusy(false);
        }
    };
    return (
        <main class="alone">
            <h1>Pair with {me.value?.host ?? 'the board'}</h1>
            {me.value?.public && (
                <p class="public">Nothing is encrypted: others in this network can read along.</p>
            )}
            <p>This browser is not paired, or not any more. On the board, run</p>
            <p><code class="big">sudo tribus pair</code></p>
            <p>and type the code that it prints. It is valid for 5 minutes, once.</p>
            <form onSubmit={(event) => void send(event)}>
                <label for="code">Code</label>
                <input id="code" class="code" autocomplete="one-time-code"
                    autocapitalize="characters" spellcheck={false} maxLength={12} value={code}
                    aria-describedby="pair-error"
                    onInput={(event) => setCode(event.currentTarget.value)} />
                <label for="device">Name of this browser, for{' '}
                    <code>tribus pair --list</code></label>
                <input id="device" maxLength={40} placeholder="phone" value={name}
                    onInput={(event) => setName(event.currentTarget.value)} />
                <p id="pair-error" class="error" role="alert">{error}</p>
                <button class="main" disabled={busy}>{busy ? 'Asking the board' : 'Pair'}</button>
            </form>
            <ThemeButton />
        </main>
    );
}
