// Words around the daemon's own sentences, which the status has (`text`, `why`).
import { PROTOCOL_TITLES, type Input } from './status';

const SECOND = 1e6;

/** "12 us", "120 ms", "4.2 s", "3 min 12 s". */
export function duration(us: number): string {
    if (us < 1000) {
        return us > 0 && us < 10 ? `${us.toFixed(1)} us` : `${Math.round(us)} us`;
    }
    if (us < SECOND) {
        return us < 10_000 ? `${(us / 1000).toFixed(1)} ms` : `${Math.round(us / 1000)} ms`;
    }
    if (us < 60 * SECOND) {
        return `${(us / SECOND).toFixed(1)} s`;
    }
    const seconds = Math.floor(us / SECOND);
    const minutes = Math.floor(seconds / 60);
    return minutes < 60
        ? `${minutes} min ${seconds % 60} s`
        : `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

export const words = (name: string): string => name.replaceAll('_', ' ');

/** "wire silent (no bytes any more) for 4.2 s" */
export function inputText(input: Input): string {
    const age = input.state_age_us;
    return input.cause === 'good' || age === null ? input.text
        : `${input.text} for ${duration(age)}`;
}

export const sum = (counts: Record<string, number> | undefined): number =>
    Object.values(counts ?? {}).reduce((total, one) => total + one, 0);

/** What the age of a page is shown as: tenths up to 10 s, so that one sees it run. */
export function ageText(ms: number): string {
    return ms < 10_000 ? `${(ms / 1000).toFixed(1)} s` : duration(Math.floor(ms / 1000) * SECOND);
}

export const protocolName = (protocol: string): string => PROTOCOL_TITLES[protocol] ?? protocol;
