// The trial of a configuration. It runs on the board; this is what the page knows of it.
import { computed, signal } from '@preact/signals';
import { errorText, post, statusOf } from './api';
import { draft, fileOnDisk, setDraft, type Draft } from './draft';
import { daemonName, freshness, newest } from './store';
import type { Status } from './status';

export const TRIAL_S = 30;
const WENT_BACK = 'The trial is over: the board went back to the configuration before.';

export interface Trial {
    daemon: string;
    number: number;
    /** On this page's clock, for the time in which the board is not heard. */
    until: number;
    /** Null: it was started elsewhere. */
    text: string | null;
    seen: boolean;
}

export interface TrialEnd {
    daemon: string;
    good: boolean;
    text: string;
}

const mine = signal<Trial | null>(null);
/** While the board is asked to keep or to go back, its status may be ahead of its answer. */
let deciding = false;
/** The trial whose end is told; a status that was under way may still name it. */
let told = 0;
/** A trial that another program or page began, and what it runs. */
let foreign: { daemon: string; number: number; fingerprint: string | undefined } | null = null;
export const trialEnd = signal<TrialEnd | null>(null);

export type Tried =
    | { kind: 'taken' }
    | { kind: 'refused'; lines: string[] }
    | { kind: 'changed' };

interface DraftAnswer {
    taken: boolean;
    lines: string[];
    trial: number;
}

/** Throws an ApiError except for a file that was changed meanwhile. */
export async function tryDraft(now: Draft): Promise<Tried> {
    const daemon = daemonName.value;
    trialEnd.value = null;
    try {
        const answer = await post<DraftAnswer>(`/api/${encodeURIComponent(daemon)}/draft`,
            { toml: now.text, seconds: TRIAL_S }, { match: now.tag });
        if (!answer.taken) {
            return { kind: 'refused', lines: answer.lines };
        }
        mine.value = { daemon, number: answer.trial, text: now.text, seen: false,
            until: performance.now() + TRIAL_S * 1000 };
        return { kind: 'taken' };
    } catch (error) {
        if (statusOf(error) === 412) {
            return { kind: 'changed' };
        }
        throw error;
    }
}

/** The trial that runs on the shown daemon, whoever started it. */
export const runningTrial = computed<Trial | null>(() => {
    const own = mine.value?.daemon === daemonName.value ? mine.value : null;
    const news = newest.value;
    const heard = freshness.value.level === 'live';
    if (!heard || !news || news.trial_left_us === null || news.trial == null) {
        return own;
    }
    return {
        daemon: daemonName.value, number: news.trial, seen: true,
        until: performance.now() + news.trial_left_us / 1000,
        text: own?.number === news.trial ? own.text : null,
    };
});

/** Called with every status: a trial that the board does not name any more is over. */
export function watchTrial(news: Status): void {
    if (deciding) {
        return;
    }
    watchForeign(news);
    const own = mine.value;
    if (!own || own.daemon !== news.name) {
        return;
    }
    if (news.trial === own.number) {
        own.seen = true;
    } else if (own.seen || performance.now() > own.until) {
        void endElsewhere(own);
    }
}

/** If the daemon runs the same text after it, it was kept. */
function watchForeign(news: Status): void {
    const { name: daemon, trial: number, fingerprint } = news;
    const before = foreign;
    foreign = number == null || number === mine.value?.number || number === told ? null
        : { daemon, number, fingerprint };
    if (before && !foreign && before.daemon === daemon && number == null) {
        const kept = before.fingerprint === fingerprint;
        end(kept, before.number, kept ? 'The trial from elsewhere was kept.' : WENT_BACK);
    }
}

/** The file on the board tells whether another page kept it. */
async function endElsewhere(own: Trial): Promise<void> {
    mine.value = null;
    const file = await fileOnDisk(own.daemon).catch(() => null);
    if (file === null) {
        end(false, own.number, 'The trial is over. Whether it was kept is not known.');
    } else if (file.text === own.text) {
        end(true, own.number, 'Kept, from elsewhere: the new configuration stands in the file.');
    } else {
        end(false, own.number, WENT_BACK);
    }
}

function end(good: boolean, number: number, text: string): void {
    trialEnd.value = { daemon: daemonName.value, good, text };
    mine.value = null;
    foreign = null;
    told = number;
}

async function act<T>(verb: string, trial: Trial, done: (answer: T) => void): Promise<void> {
    deciding = true;
    try {
        done(await post<T>(`/api/${encodeURIComponent(trial.daemon)}/${verb}`,
            { trial: trial.number }));
    } catch (error) {
        // What became of the trial is told by the statuses that follow.
        throw new Error(`That did not work: ${errorText(error)}`);
    } finally {
        deciding = false;
    }
}

export function keep(trial: Trial): Promise<void> {
    return act<{ fingerprint: string }>('confirm', trial, ({ fingerprint }) => {
        if (trial.text !== null && draft.value) {
            const tag = `"${fingerprint}"`;
            setDraft(trial.daemon, { base: trial.text, tag, text: draft.value.text });
        }
        end(true, trial.number, 'Kept: the new configuration runs and stands in the file.');
    });
}

export function goBack(trial: Trial): Promise<void> {
    return act<{ lines: string[] }>('back', trial, ({ lines }) => {
        end(true, trial.number, ['The configuration before runs again.', ...lines].join(' '));
    });
}
