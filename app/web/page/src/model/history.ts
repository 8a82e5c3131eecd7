// The last ten minutes, for the Timing screen. It holds only what was live when it came: a time
// without news stays a gap.
import type { Distribution, Status } from './status';
import { sum } from './words';

export const KEPT_S = 600;
const SAMPLE_MS = 1000;
/** A longer pause between two samples is a gap. */
const GAP_MS = 2500;
const MOST_SPELLS = 500;

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

let samples: Sample[] = [];
const spells = new Map<string, Spell[]>();
let shownName = '';

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

function extend(name: string, word: string, now: number): void {
    const list = spells.get(name) ?? [];
    spells.set(name, list);
    const last = list.at(-1);
    const at = now / 1000;
    if (last && at - last.to < SAMPLE_MS / 1000) {
        last.to = at;
        if (last.word === word) {
            return;
        }
    }
    list.push({ from: at, to: at, word });
    while (list.length > MOST_SPELLS || (list[0] && at - list[0].to > KEPT_S)) {
        list.shift();
    }
}

export function remember(news: Status, live: boolean, now: number): void {
    if (!live) {
        return;
    }
    if (news.name !== shownName) {
        shownName = news.name;
        samples = [];
        spells.clear();
    }
    sampleAt(news, now);
    for (const input of news.inputs) {
        extend(`input ${input.name}`, input.cause, now);
    }
    for (const output of news.outputs) {
        extend(`output ${output.name}`, output.state, now);
    }
}
