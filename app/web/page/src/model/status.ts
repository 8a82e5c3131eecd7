// The status object of a running daemon, as docs/status.md describes it, and what the server says
// about daemons. Only what the page reads.

export type OutputStage = 'control' | 'hold' | 'failsafe' | 'silent' | 'cannot_send';

export interface Distribution {
    count: number;
    p50_us: number;
    p99_us: number;
    max_us: number;
}

export interface Input {
    name: string;
    protocol: string;
    port: string;
    state: 'good' | 'frame_lost' | 'failsafe';
    cause: string;
    text: string;
    state_age_us: number | null;
    rate_hz: number;
    age_us: number | null;
    channels: (number | null)[];
    losses: Record<string, number>;
    rejected: Record<string, number>;
    frame_age?: Distribution;
}

export interface Output {
    name: string;
    protocol: string;
    port: string;
    inputs: string[];
    state: OutputStage;
    text: string;
    waits_for: string | null;
    input: string | null;
    outvoted: string[];
    forced: boolean;
    rate_hz: number;
    channels: (number | null)[];
    frame_lost: boolean;
    failsafe: boolean;
    deadline_misses: number;
    dropped: Record<string, number>;
    failsafe_entries: number;
    lateness: Distribution;
    latency: Distribution;
}

export interface Can {
    state: string;
    received: number;
    sent: number;
    error_frames: number;
    bus_offs: number;
}

export interface Port {
    name: string;
    kind: string;
    present: boolean;
    can?: Can | null;
}

export interface Line {
    name: string;
    line: string | number;
    present: boolean;
    role?: string;
    active?: boolean | null;
}

export interface SensorBus {
    name: string;
    port: string;
    role: string;
    found?: { address: number; type: string }[];
    faults?: { address: number; fault: string }[];
    counts: Record<string, number>;
    request_age_us?: number | null;
}

export interface Node {
    interface: string;
    state: string;
    id: number | null;
    errors: number;
    conflicts: number;
}

export interface Value {
    name: string;
    number: number | null;
    unit: string;
    age_us: number | null;
    stale: boolean;
}

export interface Machine {
    temperature_degC?: number | null;
    load_percent?: number | null;
    memory_percent?: number | null;
    supply_V?: number | null;
    undervoltage?: boolean | null;
}

export interface Status {
    type: 'status';
    version: number;
    name: string;
    file: string;
    t_us: number;
    uptime_us: number;
    trial_left_us: number | null;
    trial?: number | null;
    fingerprint?: string;
    figures_age_us: number;
    missing_realtime: string[];
    inputs: Input[];
    outputs: Output[];
    ports: Port[];
    lines: Line[];
    sensor_buses: SensorBus[];
    dronecan: Node[];
    values: Value[];
    machine: Machine;
}

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
