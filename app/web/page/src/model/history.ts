// The last ten minutes, for the Timing screen. Figures are those that were live when they came: a
// time without news stays a gap. States are the changes that the daemon tells, also those from
// before the page was opened or while it heard nothing.
import { get } from './api';
import type { Distribution, Status } from './status';
import { api } from './store';
import { sum } from './words';

export const KEPT_S = 600;
const SAMPLE_MS = 1000;
/** A longer pause between two samples is a gap. */
const GAP_MS = 2500;
/** Between two attempts to read changes. */
const PAUSE_MS = 1000;

/** The figures of one input or output at one time. */
export interface Figures {
    rate: number;
    lost: number;
    latency?: Distribution;
    lateness?: Distribution;
}

export interface Sample {
    /** Seconds on the page's clock. */
    at: number;
    /** By "input NAME" or "output NAME"; null: a gap. */
    figures: Record<string, Figures> | null;
}

/** How long a thing was in one state. */
export interface Spell {
    from: number;
    to: number;
    word: string;
}

interface Change {
    number: number;
    t_us: number;
    part: string;
    name: string;
    field: string;
    was: string | null;
    now: string;
}

interface Changes {
    newest: number;
    changes: Change[];
}

let samples: Sample[] = [];
/** By "input NAME" or "output NAME", the oldest first. */
let spells = new Map<string, Spell[]>();
/** Number of the newest change that was read. */
let read = 0;
let asking = false;
let askAgainAt = 0;
let shown = { name: '', uptime: 0, absences: 0 };

export const samplesKept = (): readonly Sample[] => samples;
export const spellsKept = (): ReadonlyMap<string, Spell[]> => spells;

function figuresOf(news: Status): Record<string, Figures> {
    const all: Record<string, Figures> = {};
    for (const input of news.inputs) {
        all[`input ${input.name}`] = {
            rate: input.rate_hz, lost: sum(input.losses) + sum(input.rejected),
        };
    }
    for (const output of news.outputs) {
        all[`output ${output.name}`] = {
            rate: output.rate_hz,
            lost: sum(output.dropped) + output.deadline_misses,
            latency: output.latency,
            lateness: output.lateness,
        };
    }
    return all;
}

function sampleAt(news: Status, now: number): void {
    const last = samples.at(-1);
    const since = last ? now - last.at * 1000 : Infinity;
    if (since < SAMPLE_MS) {
        return;
    }
    if (last && since > GAP_MS) {
        samples.push({ at: last.at + 0.001, figures: null });
    }
    samples.push({ at: now / 1000, figures: figuresOf(news) });
    while (samples.length > 0 && now / 1000 - samples[0]!.at > KEPT_S) {
        samples.shift();
    }
}

/** The part is in this state now, since `from` or since the change that says so. */
function extend(name: string, word: string, at: number, from: number): void {
    const list = spells.get(name) ?? [];
    spells.set(name, list);
    const last = list.at(-1);
    if (!last || from > last.to) {
        list.push({ from, to: at, word });
    } else if (last.word === word) {
        last.to = at;
    }
    while (list[0] && at - list[0].to > KEPT_S) {
        list.shift();
    }
}

/** `at`: when the change happened. A part whose first change this is was so before. */
function place(change: Change, at: number): void {
    const word = change.field === (change.part === 'input' ? 'cause' : 'state');
    const name = `${change.part} ${change.name}`;
    if (!word || !['input', 'output'].includes(change.part)) {
        return;
    }
    const list = (spells.get(name) ?? []).filter((one) => one.from < at);
    spells.set(name, list);
    const last = list.at(-1);
    if (last) {
        last.to = at;
    } else if (change.was) {
        list.push({ from: at - KEPT_S, to: at, word: change.was });
    }
    list.push({ from: at, to: at, word: change.now });
}

async function readChanges(news: Status, now: number): Promise<void> {
    if (asking || news.changes === read || now < askAgainAt) {
        return;
    }
    asking = true;
    const before = shown;
    try {
        const answer = await get<Changes>(api(`changes/${read}`));
        for (const change of before === shown ? answer.changes : []) {
            read = change.number;
            place(change, now / 1000 - (news.t_us - change.t_us) / 1e6);
        }
        askAgainAt = answer.changes.length > 0 ? 0 : now + PAUSE_MS;
    } catch {
        askAgainAt = now + PAUSE_MS;
    } finally {
        asking = false;
    }
}

export function remember(news: Status, live: boolean, now: number): void {
    if (!live) {
        return;
    }
    if (news.name !== shown.name) {
        samples = [];
    }
    if (news.name !== shown.name || news.uptime_us < shown.uptime) {
        // Another process counts its changes anew.
        spells = new Map();
        read = 0;
        shown = { name: news.name, uptime: 0, absences: news.absences };
    }
    const at = now / 1000;
    // A daemon that did not run saw nothing meanwhile.
    const stood = news.absences !== shown.absences;
    const since = (age: number | null) => stood ? at : at - (age ?? news.uptime_us) / 1e6;
    Object.assign(shown, { uptime: news.uptime_us, absences: news.absences });
    sampleAt(news, now);
    for (const one of news.inputs) {
        extend(`input ${one.name}`, one.cause, at, since(one.state_age_us));
    }
    for (const one of news.outputs) {
        extend(`output ${one.name}`, one.state, at, since(one.state_age_us));
    }
    void readChanges(news, now);
}
