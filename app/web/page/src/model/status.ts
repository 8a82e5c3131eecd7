// The status object of a running daemon, as docs/status.md describes it, and what the server says
// about daemons.

export interface Distribution {
    count: number;
    p50_us: number;
    p99_us: number;
    max_us: number;
}

// The rows of a status (app/status/fields.h): rows of a status
export interface Input {
    name: string;
    protocol: string;
    port: string;
    state: 'good' | 'frame_lost' | 'failsafe';
    good: boolean;
    cause: 'good' | 'never_seen' | 'wire_silent' | 'garbled' | 'radio_lost' | 'stale' | 'implausible' | 'channels_missing' | 'no_key' | 'forged' | 'replayed' | 'late' | 'unproved';
    sign: 'none' | 'failsafe_flag' | 'value_rule' | 'frame_lost_run' | 'frame_lost_ratio';
    text: string;
    state_age_us: number | null;
    rate_hz: number;
    interval_us: number;
    age_us: number | null;
    channels: (number | null)[];
    frame_lost: boolean;
    failsafe: boolean;
    bytes: number;
    frames: number;
    frame_lost_frames: number;
    failsafe_frames: number;
    implausible: { frames: number; channel: number | null; us: number | null; plausible_us: [number, number] | null };
    two_senders: boolean;
    skipped_bytes: number;
    device_losses: number;
    rejected: Record<string, number>;
    losses: Record<string, number>;
    frame_age: Distribution;
}

export interface Pipeline {
    name: string;
    from: string[];
    to: string[];
}

export interface Output {
    name: string;
    protocol: string;
    port: string;
    inputs: string[];
    state: 'control' | 'hold' | 'failsafe' | 'silent' | 'cannot_send';
    obstacle: 'device' | 'bus' | 'busy' | 'receiver' | 'epoch' | null;
    text: string;
    state_age_us: number | null;
    waits_for: string | null;
    why: string | null;
    hold_us: number | null;
    action: 'preset' | 'hold' | 'silence' | null;
    marks_frame_lost: boolean;
    forced: boolean;
    awaits_release: boolean;
    module: 'heard' | 'silent' | 'unreadable' | null;
    input: string | null;
    outvoted: string[];
    by_preset: number[];
    rate_hz: number;
    period_us: number;
    channels: (number | null)[];
    frame_lost: boolean;
    failsafe: boolean;
    cause: 'good' | 'never_seen' | 'wire_silent' | 'garbled' | 'radio_lost' | 'stale' | 'implausible' | 'channels_missing' | 'no_key' | 'forged' | 'replayed' | 'late' | 'unproved';
    frames: number;
    overruns: number;
    deadline_misses: number;
    dropped: Record<string, number>;
    foreign_frames: number;
    hold_entries: number;
    failsafe_entries: number;
    recoveries: number;
    changeovers: number;
    lateness: Distribution;
    latency: Distribution;
}

export interface Port {
    name: string;
    kind: 'serial' | 'can';
    present: boolean;
    text: string;
    can?: Can;
}

export interface Can {
    state: 'ready' | 'warning' | 'passive' | 'stalled' | 'bus_off' | 'down' | 'gone';
    received: number;
    sent: number;
    confirmed: number;
    queue_full: number;
    abandoned: number;
    stalls: number;
    bus_offs: number;
    downs: number;
    error_frames: number;
    missing_acknowledges: number;
    receive_overflows: number;
    implausible_times: number;
}

export interface Line {
    name: string;
    line: string;
    present: boolean;
    text: string;
    role: 'link' | 'failsafe' | 'fresh' | 'force_failsafe' | 'select' | 'inverter' | 'button' | 'switch';
    active: boolean | null;
}

export interface SensorBus {
    name: string;
    port: string;
    role: 'sensor' | 'receiver';
    text: string;
    found?: { address: number; type: string | null; type_id: number; bytes: number }[];
    faults?: { address: number; fault: string; sent_bytes: number | null }[];
    first_address?: number | null;
    sensors?: number;
    request_age_us?: number | null;
    counts: Record<string, number>;
    collisions: number;
}

export interface DronecanNode {
    interface: string;
    state: 'allocating' | 'online' | 'conflict';
    text: string;
    id: number | null;
    sent: number;
    received: number;
    errors: number;
    requests: number;
    dropped: number;
    conflicts: number;
}

export interface Value {
    name: string;
    number: number | null;
    unit: string;
    age_us: number | null;
    text: string;
    stale: boolean;
}

export interface Machine {
    temperature_degC?: number | null;
    load_percent?: number | null;
    memory_percent?: number | null;
    supply_V?: number | null;
    undervoltage?: number | null;
    uptime_s?: number | null;
}

export interface Status {
    type: 'status';
    version: number;
    name: string;
    file: string;
    t_us: number;
    unix_time_us: number;
    uptime_us: number;
    trial_left_us: number | null;
    trial: number | null;
    text: string;
    fingerprint: string;
    figures_age_us: number | null;
    changes: number;
    absences: number;
    missing_realtime: string[];
    inputs: Input[];
    pipelines: Pipeline[];
    outputs: Output[];
    ports: Port[];
    lines: Line[];
    sensor_buses: SensorBus[];
    dronecan: DronecanNode[];
    values: Value[];
    machine: Machine;
}

export const PROTOCOL_TITLES: Record<string, string> = {
    'ibus': 'i.Bus',
    'sbus': 'SBUS',
    'sumd': 'SUMD',
    'crsf': 'CRSF',
    'crsf-telemetry': 'CRSF telemetry',
    'ghst': 'GHST',
    'srxl': 'SRXL',
    'fport': 'F.Port',
    'fport2': 'F.Port 2',
    'fbus': 'FBUS',
    'ibus2': 'i-BUS2',
    'exbus': 'EX Bus',
    'exbus-telemetry': 'EX Bus telemetry',
    'dsm': 'DSM',
    'msp': 'MSP',
    'sitl': 'SITL',
    'network': 'Network',
    'mavlink': 'MAVLink',
    'mavlink-telemetry': 'MAVLink telemetry',
    'joystick': 'Joystick',
    'gamepad': 'Gamepad',
    'pwm': 'PWM',
    'ppm': 'PPM',
    'can': 'CAN',
    'dbc': 'DBC',
    'sensors': 'sensors on CAN',
    'dronecan': 'DroneCAN',
    'ibus-sensor': 'the i.Bus sensor bus',
};
// end of rows

export type Role = 'look' | 'change' | null;

export interface Me {
    role: Role;
    host: string;
    public: boolean;
    version: string;
    /** The screens that the server can fill; absent: all. */
    screens?: string[];
}

export interface Daemon {
    name: string;
    state: 'running' | 'absent' | 'hung';
    file: string;
}

export interface Mistake {
    line: number;
    column: number;
    text: string;
}
