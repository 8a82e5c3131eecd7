// Judges how old what the page shows is, by the page's own clock.
import { ageText, duration } from './words';
import type { Status } from './status';

export const LATE_MS = 500;
export const STALE_MS = 1000;
export const RECONNECT_MS = 3000;

/** live: shown as it is; late: grey; stale: banner, and every value struck out. */
export type Level = 'live' | 'late' | 'stale';

/** What the page knows of its stream, apart from the time. */
export type LinkState =
    | { kind: 'opening'; why?: string }
    | { kind: 'open' }
    | { kind: 'gone'; reason: string }
    | { kind: 'ended'; reason: string }
    | { kind: 'hidden' };

export interface Freshness {
    level: Level;
    /** For the lamp in the top bar. */
    short: string;
    /** For the banner; empty unless stale. */
    text: string;
}

/** How much the delay of an undisturbed stream may seem to change a second: clocks differ. */
const CLOCK_DRIFT = 0.0005;

export class Judge {
    private arrivedAt: number | null = null;
    private arrivedWall = 0;
    private leastOffset: number | null = null;
    private lateness = 0;
    private figuresAge = 0;
    private lastBoardTime = 0;

    /** A new connection has no queue behind it. */
    connected(): void {
        this.leastOffset = null;
        this.lateness = 0;
    }

    arrived(status: Status, now: number, wall: number): void {
        const board = status.t_us / 1000;
        const offset = now - board;
        if (this.leastOffset === null || board < this.lastBoardTime) {
            this.leastOffset = offset;
        } else {
            const drift = (board - this.lastBoardTime) * CLOCK_DRIFT;
            this.leastOffset = Math.min(this.leastOffset + drift, offset);
        }
        this.lateness = offset - this.leastOffset;
        this.lastBoardTime = board;
        // Until the first figures they are as old as the daemon.
        this.figuresAge = (status.figures_age_us ?? status.uptime_us) / 1000;
        this.arrivedAt = now;
        this.arrivedWall = wall;
    }

    /** Since the newest status came, in ms; null: none came yet. */
    silence(now: number, wall: number): number | null {
        if (this.arrivedAt === null) {
            return null;
        }
        // performance.now() stands still while some machines sleep, the wall clock does not.
        return Math.max(now - this.arrivedAt, wall - this.arrivedWall);
    }

    /** How long the newest status was under way, beyond the usual, in ms. */
    delay(): number {
        return this.lateness;
    }

    judge(link: LinkState, now: number, wall: number): Freshness {
        const silence = this.silence(now, wall);
        const known = silence === null ? '' : ` What you see is ${ageText(silence)} old.`;
        if (link.kind === 'gone') {
            return stale('daemon gone', `The daemon is gone: ${link.reason}.${known}`);
        }
        if (link.kind === 'ended') {
            return stale('ended', `This page gets nothing any more: ${link.reason}.${known}`);
        }
        if (silence === null || link.kind === 'hidden') {
            const why = link.kind === 'opening' ? link.why ?? '' : '';
            return stale('connecting', `Waiting for news from the board.${why}${known}`);
        }
        return this.byAge(silence, (link.kind === 'opening' ? link.why ?? '' : '') + known);
    }

    private byAge(silence: number, known: string): Freshness {
        const age = silence + this.lateness;
        const figures = this.figuresAge + age;
        const level = levelOf(Math.max(age, this.figuresAge > LATE_MS ? figures : 0));
        if (level === 'live') {
            return { level, short: 'live', text: '' };
        }
        if (this.figuresAge > LATE_MS && silence < LATE_MS) {
            const hung = `The daemon's data thread hangs: it has published nothing for `
                + `${duration(figures * 1000)}. Everything here is that old.`;
            return { level, short: 'hangs', text: level === 'stale' ? hung : '' };
        }
        if (this.lateness > silence) {
            const slow = `The network is slow: what arrives is ${ageText(age)} old.`;
            return { level, short: ageText(age), text: level === 'stale' ? slow : '' };
        }
        const text = `No news from the board.${known}`;
        return { level, short: ageText(age), text: level === 'stale' ? text : '' };
    }
}

function levelOf(age: number): Level {
    return age >= STALE_MS ? 'stale' : age >= LATE_MS ? 'late' : 'live';
}

function stale(short: string, text: string): Freshness {
    return { level: 'stale', short, text };
}
