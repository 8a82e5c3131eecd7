// Doctor and Learn of the mock.
const FINDINGS = [
    { severity: 'problem', id: 'port.login', where: '/dev/ttyAMA0', what: 'a login runs on it',
        why: 'What the receiver sends is typed into the login.', fix: 'Stop it:',
        commands: ['sudo systemctl disable --now serial-getty@ttyAMA0'] },
    { severity: 'advice', id: 'machine.kernel_not_realtime', where: 'machine',
        what: 'the kernel 6.18.44 is not PREEMPT_RT',
        why: 'It works, but now and then a frame is late by milliseconds.', fix: 'Debian has one:',
        commands: ['sudo apt install linux-image-rt-arm64'] },
];

const port = (node, users, heard) => ({
    node, device: node, kind: 'PL011 (serial)', driver: 'uart-pl011', tried: heard !== null,
    abilities: [{ protocol: 'i.Bus', can: 'yes', because: '' },
        { protocol: 'SBUS', can: 'no', because: 'it needs an inverter' }],
    users, heard, configuration: [],
});

export function doctorReport(device) {
    const heard = device ? { sound: 'frames', protocol: 'ibus', bytes: 12_480, frames: 390,
        inverted: false, channels: 14, period_us: 7700, least_us: 1000, most_us: 2000 } : null;
    return {
        machine: { model: 'Raspberry Pi 4', kernel: '6.18.44', realtime_kernel: false,
            governors: ['ondemand'], throttled: false, temperature: 51 },
        ports: [
            port('/dev/ttyAMA5', [{ process: 812, command: 'tribus', unit: 'tribus@boat',
                login: false }], null),
            port('/dev/ttyAMA4', [], device === '/dev/ttyAMA4' ? heard : null),
        ],
        can: [{ name: 'can0', kind: 'mcp251x', up: true, bit_rate: 500_000, data_bit_rate: null,
            fd: false, queue_length: 10, restart_ms: 100, transmit_errors: 0, receive_errors: 0 }],
        spi: [{ device: '/dev/spidev0.0', exists: true, may_open: true, group: 'spi', refusal: null,
            loopback: null, configuration: ['[output.servos]', 'protocol = "sbus"',
                'spi      = "/dev/spidev0.0"'] }],
        findings: FINDINGS,
    };
}

const STEPS = {
    waiting: { step: 'waiting', text: 'Transmitter and receiver on. Move every stick and every '
        + 'switch to both of its ends, twice. Then throttle low, hands off.', lines: [] },
    off: { step: 'off', text: 'Switch the transmitter OFF now and wait eight seconds.', lines: [] },
    on: { step: 'on', text: 'Switch the transmitter ON again.', lines: [] },
    done: { step: 'done', text: 'The loss of this link is recognised with these lines.',
        lines: ['failsafe_when = [{ channel = 3, below = 945 }]'] },
    stop: { step: 'broken', text: 'Stopped; nothing was learned.', lines: [] },
};

const AFTER = { waiting: 'off', off: 'on', on: 'done' };

export function learn(board, verb) {
    board.learnStep = verb === 'start' ? 'waiting' : verb === 'next' ? AFTER[board.learnStep]
        : 'stop';
    return STEPS[board.learnStep] ?? STEPS.stop;
}
