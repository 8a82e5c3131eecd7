// Words around the daemon's own sentences, which the status has (`text`, `waits_for`).
import type { Input, Output } from './status';

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
    if (input.cause === 'good') {
        return input.state === 'frame_lost' ? 'good, newest frame marked frame-lost' : 'good';
    }
    const age = input.state_age_us;
    return input.text + (age === null ? '' : ` for ${duration(age)}`);
}

/** What the output does with the wire meanwhile. */
export function sendsText(output: Output): string {
    switch (output.state) {
        case 'hold': {
            const left = (output.hold_us ?? 0) - (output.state_age_us ?? 0);
            return left > 0 ? `failsafe in ${duration(left)}` : '';
        }
        case 'failsafe':
            return 'it sends its presets';
        case 'silent':
            return 'silent: it sends nothing';
        default:
            return '';
    }
}

/** Why an output is not under control: what it waits for, and what its inputs say. */
export function whyText(output: Output, inputs: Input[]): string {
    const parts: string[] = [];
    const sends = sendsText(output);
    if (sends) {
        parts.push(sends);
    }
    if (output.outvoted.length > 0) {
        parts.push(`outvoted by the others: ${output.outvoted.join(', ')}`);
    }
    const feeding = inputs.filter((input) => output.inputs.includes(input.name));
    // A lost input says the same of itself, and for how long it has been so.
    const awaited = feeding.find((input) => output.waits_for?.startsWith(`${input.name}: `));
    const lost = awaited !== undefined && awaited.cause !== 'good' && awaited.cause !== 'unproved';
    if (output.waits_for && !lost) {
        parts.push(`waits for ${output.waits_for}`);
    }
    for (const input of feeding) {
        if ((output.state !== 'control' || input.state !== 'good') && (input !== awaited || lost)) {
            parts.push(`${input.name}: ${inputText(input)}`);
        }
    }
    return parts.join('; ');
}

export const sum = (counts: Record<string, number> | undefined): number =>
    Object.values(counts ?? {}).reduce((total, one) => total + one, 0);

/** What the age of a page is shown as: tenths up to 10 s, so that one sees it run. */
export function ageText(ms: number): string {
    return ms < 10_000 ? `${(ms / 1000).toFixed(1)} s` : duration(Math.floor(ms / 1000) * SECOND);
}

export const PROTOCOLS: Record<string, string> = {
    ibus: 'i.Bus', ibus2: 'i-BUS2', sbus: 'SBUS', crsf: 'CRSF', sumd: 'SUMD', ghst: 'GHST',
    srxl: 'SRXL', fport: 'F.Port', fport2: 'F.Port 2', fbus: 'FBUS', exbus: 'EX Bus', dsm: 'DSM',
    msp: 'MSP', mavlink: 'MAVLink', sitl: 'SITL', joystick: 'Joystick', gamepad: 'Gamepad', pwm: 'PWM', can: 'CAN', dbc: 'DBC', dronecan: 'DroneCAN',
};
export const protocolName = (protocol: string): string => PROTOCOLS[protocol] ?? protocol;
