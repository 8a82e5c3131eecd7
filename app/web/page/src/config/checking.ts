// What the checker of the board says about the draft, 300 ms after the last key.
import { signal } from '@preact/signals';
import { errorText, post, postForText } from '../model/api';
import type { Mistake } from '../model/status';
import { absent, api } from '../model/store';

const QUIET_MS = 300;

export interface ChangedOutput {
    output: string;
    channels: { channel: number; now_us: number | null; then_us: number | null }[];
}

export interface Verdict {
    text: string;
    mistakes: Mistake[];
    /** In the words of `tribus diff`; null: no daemon runs that it could be compared with. */
    lines: string[] | null;
    same: boolean;
    /** What it would send now, with the sticks as they are. */
    outputs: ChangedOutput[];
    error: string;
}

/** Null while the newest text is not judged yet. */
export const verdict = signal<Verdict | null>(null);
/** The address of the picture of the draft. */
export const picture = signal('');

let timer = 0;
let newest = 0;

export function checkSoon(text: string, wait = QUIET_MS): void {
    clearTimeout(timer);
    newest += 1;
    const number = newest;
    verdict.value = null;
    timer = window.setTimeout(() => void check(text, number), wait);
}

export function stopChecking(): void {
    clearTimeout(timer);
    newest += 1;
    verdict.value = null;
    picture.value = '';
}

async function judged(text: string): Promise<Verdict> {
    const { mistakes } = await post<{ mistakes: Mistake[] }>(api('check'), { toml: text });
    if (mistakes.length > 0 || absent.peek()) {
        return { text, mistakes, lines: null, same: false, outputs: [], error: '' };
    }
    const diff = await post<{ same: boolean; lines: string[]; outputs: ChangedOutput[] }>(
        api('diff'), { toml: text });
    return { text, mistakes, ...diff, error: '' };
}

async function check(text: string, number: number): Promise<void> {
    let found: Verdict;
    try {
        found = await judged(text);
    } catch (error) {
        found = { text, mistakes: [], lines: null, same: false, outputs: [],
            error: errorText(error) };
    }
    if (number === newest) {
        verdict.value = found;
        await draw(found, number);
    }
}

async function draw(found: Verdict, number: number): Promise<void> {
    if (found.error || found.mistakes.length > 0) {
        return;
    }
    try {
        const svg = await postForText(api('graph'), { toml: found.text });
        if (number === newest) {
            picture.value = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
        }
    } catch {
        picture.value = '';
    }
}
