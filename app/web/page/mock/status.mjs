// Makes status objects as a daemon sends them, with channels that move.

const CAUSES = ['wire_silent', 'garbled', 'radio_lost', 'stale', 'implausible', 'channels_missing',
    'no_key', 'forged', 'replayed', 'late'];

/** Every state that the page must draw; the tests and `mock.mjs --scene` name them. */
export const SCENES = [
    'good', 'never_seen', 'hold', 'failsafe', 'forced', 'awaits_release', 'silent',
    'unproved', 'cannot_send_device', 'cannot_send_bus', 'frame_lost', 'absent_channel', 'reversed', 'undervoltage', ...CAUSES,
];

const distribution = (p50, p99, max) => ({ count: 400, p50_us: p50, p99_us: p99, max_us: max });
const jitter = (least, most) => least + Math.random() * (most - least);

function wave(channel, seconds) {
    return Math.round(1500 + 420 * Math.sin(seconds * (0.4 + channel * 0.13) + channel));
}

function sticks(count, seconds) {
    return Array.from({ length: count }, (_, i) =>
        i === 2 ? 1120 : i < 4 ? wave(i, seconds) : [1000, 1500, 2000][i % 3]);
}

export function input(name, protocol, port, channels, seconds) {
    return {
        name, protocol, port, state: 'good', good: true, cause: 'good', sign: 'none', text: 'good',
        state_age_us: 3_004_476,
        rate_hz: jitter(129, 131), interval_us: 7700, age_us: Math.round(jitter(300, 7700)),
        channels: sticks(channels, seconds), frame_lost: false, failsafe: false, bytes: 11_584,
        frames: 362, frame_lost_frames: 0, failsafe_frames: 0, skipped_bytes: 0, device_losses: 0,
        rejected: { checksum: 0, damaged: 0, length: 0 },
        losses: Object.fromEntries(CAUSES.map((cause) => [cause, 0])),
        frame_age: distribution(7877.2, 11_373.5, 13_308.4),
    };
}

export function output(name, protocol, port, inputs, from) {
    return {
        name, protocol, port, inputs, state: 'control', text: `under control of ${inputs[0]}`,
        obstacle: null, waits_for: null, why: null, forced: false, awaits_release: false, input: inputs[0],
        outvoted: [], by_preset: [], state_age_us: 2_900_000, hold_us: 300_000,
        rate_hz: jitter(70.5, 71.5),
        period_us: 14_000, channels: [...from.channels, 1500, 1500, 1500, 1500].slice(0, 18),
        frame_lost: false, failsafe: false, cause: 'good', frames: 232, overruns: 0,
        deadline_misses: 0, dropped: { busy: 0, lost: 0, unavailable: 0 }, foreign_frames: 0,
        hold_entries: 0, failsafe_entries: 0, recoveries: 0, changeovers: 0,
        lateness: distribution(0.1, jitter(12, 40), jitter(60, 90)),
        latency: distribution(45.3, jitter(1500, 2846), jitter(3000, 3794)),
    };
}

const PRESETS = Array.from({ length: 18 }, (_, i) => i === 2 ? 988 : 1500);

function lose(status, cause, age) {
    for (const one of status.inputs) {
        const stops = ['wire_silent', 'garbled', 'no_key', 'forged', 'replayed'].includes(cause);
        Object.assign(one, {
            state: 'failsafe', cause, state_age_us: age,
            sign: cause === 'radio_lost' ? 'failsafe_flag' : 'none',
            text: `${cause.replaceAll('_', ' ')} (as the daemon says)`,
            rate_hz: stops ? 0 : one.rate_hz, age_us: stops ? age + 100_000 : one.age_us,
            channels: stops ? sticks(one.channels.length, 1) : one.channels,
        });
        one.losses[cause] = 1;
    }
}

function all(status, change) {
    for (const one of status.outputs) {
        Object.assign(one, change);
        one.why = change.why ?? whyOf(one, status);
    }
}

/** The daemon says it, and the page prints it: any words do. */
function whyOf(output, status) {
    const lost = status.inputs.filter((one) =>
        output.inputs.includes(one.name) && one.cause !== 'good' && one.cause !== 'unproved');
    const sends = { hold: 'failsafe in 180 ms', failsafe: 'it sends its presets',
        silent: 'it sends nothing' }[output.state];
    const awaited = output.waits_for ?? lost.map((one) => `${one.name}: ${one.text} for 4.2 s`)[0];
    return [sends, awaited && `waits for ${awaited}`].filter(Boolean).join('; ') || null;
}

const failsafe = { state: 'failsafe', text: 'in failsafe', input: null, frame_lost: true, failsafe: true,
    channels: PRESETS, failsafe_entries: 1 };

const CHANGES = {
    good() {},
    never_seen(status) {
        for (const one of status.inputs) {
            Object.assign(one, { state: 'failsafe', cause: 'never_seen', state_age_us: null,
                text: 'never seen', rate_hz: 0, age_us: null, channels: [] });
        }
        all(status, failsafe);
    },
    hold(status) {
        lose(status, 'wire_silent', 120_000);
        all(status, {
            state: 'hold', text: 'holding the last values', input: null, frame_lost: true,
            cause: 'wire_silent', state_age_us: 120_000,
            channels: [...sticks(14, 1), 1500, 1500, 1500, 1500] });
    },
    failsafe(status) {
        lose(status, 'radio_lost', 4_200_000);
        all(status, failsafe);
    },
    forced: (status) => all(status, {
        ...failsafe, text: 'in failsafe, forced', forced: true, waits_for: 'the GPIO line that forces failsafe',
    }),
    awaits_release: (status) => all(status, {
        ...failsafe, text: 'in failsafe until release_when is true', awaits_release: true,
    }),
    silent(status) {
        lose(status, 'wire_silent', 9_000_000);
        all(status, { ...failsafe, state: 'silent', rate_hz: 0 });
    },
    unproved(status) {
        lose(status, 'unproved', 200_000);
        all(status, { ...failsafe, waits_for: 'receiver: good for 0.2 of 0.5 s' });
    },
    cannot_send_device(status) {
        all(status, { ...failsafe, state: 'cannot_send', text: 'cannot send: its device is gone',
            obstacle: 'device', rate_hz: 0 });
        Object.assign(status.ports.find((port) => port.name === status.outputs[0].port),
            { present: false, text: 'is gone; waiting for it' });
    },
    cannot_send_bus: (status) => all(status, { ...failsafe, state: 'cannot_send',
        text: 'cannot send: the bus takes nothing', obstacle: 'bus', rate_hz: 0 }),
    frame_lost(status) {
        status.inputs[0].state = 'frame_lost';
    },
    absent_channel(status) {
        status.inputs[0].channels[4] = null;
    },
    reversed(status) {
        status.inputs[0].channels[1] = 1830;
        status.outputs[0].channels[1] = 1170;
    },
    undervoltage(status) {
        status.machine.undervoltage = true;
    },
};
for (const cause of CAUSES) {
    CHANGES[cause] ??= (status) => {
        lose(status, cause, 4_200_000);
        all(status, failsafe);
    };
}

function boat(seconds) {
    const receiver = input('receiver', 'ibus', '/dev/ttyAMA5', 14, seconds);
    return {
        inputs: [receiver],
        outputs: [output('servos', 'sbus', '/dev/ttyAMA3', ['receiver'], receiver)],
        pipelines: [{ name: 'main', from: ['receiver'], to: ['servos'] }],
        ports: [
            { name: '/dev/ttyAMA5', kind: 'serial', present: true, text: 'is there' },
            { name: '/dev/ttyAMA3', kind: 'serial', present: true, text: 'is there' },
        ],
        lines: [], sensor_buses: [], dronecan: [], values: [], missing_realtime: [],
    };
}

/** Three receivers of which one is outvoted, and everything else that a status can have. */
function rover(seconds) {
    const inputs = [
        input('left', 'ibus', '/dev/ttyAMA5', 14, seconds),
        input('right', 'ibus', '/dev/ttyAMA2', 14, seconds),
        input('tail', 'sbus', '/dev/ttyAMA4', 16, 0),
    ];
    const names = inputs.map((one) => one.name);
    const servos = output('servos', 'sbus', '/dev/ttyAMA3', names, inputs[0]);
    servos.outvoted = ['tail'];
    servos.why = 'tail: outvoted by the others';
    const can = { state: 'ready', received: 12_345, sent: 4321, confirmed: 4321, error_frames: 2,
        bus_offs: 0 };
    return {
        inputs,
        outputs: [servos, output('bus', 'can', 'can0', ['left', 'right'], inputs[1])],
        pipelines: [{ name: 'main', from: names, to: ['servos', 'bus'] }],
        ports: [
            ...[2, 3, 4, 5].map((n) =>
                ({ name: `/dev/ttyAMA${n}`, kind: 'serial', present: true, text: 'is there' })),
            { name: 'can0', kind: 'can', present: true, text: 'works', can },
            { name: 'can1', kind: 'can', present: true, text: 'bus-off: the controller left the bus',
                can: { ...can, state: 'bus_off', bus_offs: 3, error_frames: 99 } },
        ],
        lines: [{ name: 'stop', line: 'GPIO5', present: true, role: 'force_failsafe', active: false,
            text: 'is not active' },
            { name: 'lamp', line: 'gpiochip0 7', present: false, role: 'link', active: null,
                text: 'is gone; waiting for it' }],
        sensor_buses: [{ name: 'telemetry', port: '/dev/ttyAMA4', role: 'receiver', collisions: 0,
            text: 'reads external voltage at address 1',
            found: [{ address: 1, type: 'external_voltage', type_id: 3, bytes: 2 }],
            counts: { requests: 900, replies: 880, misses: 20, wrong: 0 } }],
        dronecan: [{ interface: 'can0', state: 'online', id: 42, text: 'this program is DroneCAN node 42', sent: 1, received: 1, errors: 0,
            requests: 1, dropped: 0, conflicts: 0 }],
        values: [
            { name: 'battery', number: 15.2, unit: 'V', age_us: 104_000, stale: false,
                text: '15.2 V' },
            { name: 'motor_temperature', number: 61.4, unit: 'degC', age_us: 12_400_000,
                stale: true, text: 'stale: 61.4 degC' },
        ],
        missing_realtime: ['memory is not locked: no permission'],
    };
}

const PLANTS = { boat, rover };

/** What a daemon would say `seconds` after the start of the mock. */
export function statusOf(name, scene, seconds, extra = {}) {
    const status = {
        type: 'status', version: 1, name, file: `/etc/tribus/${name}.toml`,
        t_us: Math.round(performance.now() * 1000), unix_time_us: Date.now() * 1000,
        uptime_us: Math.round(seconds * 1e6), trial_left_us: null, trial: null,
        text: 'servos: under control of receiver; receiver: good',
        fingerprint: 'f1', figures_age_us: 60_000,
        ...(PLANTS[name] ?? boat)(seconds),
        machine: { temperature_degC: 51.2, load_percent: 12, memory_percent: 31, supply_V: 5.08,
            undervoltage: false },
    };
    CHANGES[scene]?.(status);
    return { ...status, ...extra };
}
