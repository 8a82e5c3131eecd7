import { useEffect, useState } from 'preact/hooks';
import { errorText, post } from '../model/api';
import { mayChange } from '../model/store';
import { protocolName } from '../model/words';

const LISTEN_S = 3;
const LIMIT_MS = 60_000;

interface Finding {
    severity: string;
    id: string;
    where: string;
    what: string;
    why: string;
    fix: string;
    commands: string[];
}

interface Heard {
    sound: string;
    protocol: string | null;
    bytes: number;
    frames: number;
    channels?: number;
}

interface PortReport {
    node: string;
    kind: string;
    abilities: { protocol: string; can: string; because: string }[];
    users: { process: number; command: string; unit: string }[];
    heard: Heard | null;
}

interface Report {
    machine: { model: string; kernel: string } | null;
    ports: PortReport[];
    can: { name: string; kind: string; up: boolean; bit_rate: number | null }[];
    spi: { device: string; exists: boolean; configuration: string[] }[];
    findings: Finding[];
}

function FindingItem({ one }: { one: Finding }) {
    return (
        <li class={`finding ${one.severity}`}>
            <h3>{one.severity}: {one.where}: {one.what}</h3>
            <p>{one.why}</p>
            <p>{one.fix}</p>
            {one.commands.length > 0 && <pre class="commands">{one.commands.join('\n')}</pre>}
        </li>
    );
}

function heardText(heard: Heard): string {
    if (heard.bytes === 0) {
        return 'Nothing was heard.';
    }
    return heard.protocol
        ? `Heard ${protocolName(heard.protocol)}: ${heard.frames} frames, ${heard.channels ?? 0} `
            + 'channels.'
        : `Heard ${heard.bytes} bytes, but no frames (${heard.sound}).`;
}

interface PortProps {
    port: PortReport;
    busy: boolean;
    listen: (device: string) => void;
}

function PortItem({ port, busy, listen }: PortProps) {
    const user = port.users[0];
    const can = port.abilities.map((one) => `${one.protocol}: ${one.can}`
        + (one.because && ` (${one.because})`)).join('; ');
    return (
        <li>
            <h3>{port.node}</h3>
            <p>{port.kind}. {can}</p>
            {port.heard && <p role="status"><strong>{heardText(port.heard)}</strong></p>}
            {user ? <p class="quiet">In use by {user.unit || user.command}.</p>
                : (
                    <button disabled={busy || !mayChange.value} onClick={() => listen(port.node)}
                        aria-label={`Listen ${LISTEN_S} s on ${port.node}`}>
                        Listen {LISTEN_S} s
                    </button>
                )}
        </li>
    );
}

function ReportView({ report, busy, listen }: { report: Report } & Omit<PortProps, 'port'>) {
    return (
        <>
            <section>
                <h2>Findings</h2>
                {report.findings.length === 0 && <p>No problems were found.</p>}
                <ul>{report.findings.map((one) => (
                    <FindingItem key={one.id + one.where} one={one} />
                ))}</ul>
            </section>
            <section>
                <h2>Ports</h2>
                {report.ports.length + report.can.length + report.spi.length === 0
                    && <p>No serial port, no CAN interface and no SPI port was found.</p>}
                <ul class="list">{report.ports.map((port) => (
                    <PortItem key={port.node} port={port} busy={busy} listen={listen} />
                ))}{report.can.map((one) => (
                    <li key={one.name}><h3>CAN {one.name}</h3>
                        <p>{one.kind}, {one.up ? 'up' : 'down'}
                            {one.bit_rate !== null && `, ${one.bit_rate / 1000} kbit/s`}</p></li>
                ))}{report.spi.map((one) => (
                    <li key={one.device}><h3>{one.device}</h3>
                        <p>SPI port: SBUS without an inverter, servos at MOSI or a receiver at
                            MISO.</p>
                        {one.configuration.length > 0
                            && <pre class="commands">{one.configuration.join('\n')}</pre>}</li>
                ))}</ul>
            </section>
            {report.machine && <p class="quiet">{report.machine.model} {report.machine.kernel}</p>}
        </>
    );
}

export function DoctorScreen() {
    const [report, setReport] = useState<Report | null>(null);
    const [doing, setDoing] = useState('');
    const [error, setError] = useState('');
    const ask = async (device: string | null) => {
        setDoing(device ? `Doctor listens on ${device} for ${LISTEN_S} s.`
            : 'Doctor examines ports and machine.');
        setError('');
        try {
            setReport(await post<Report>('/api/doctor', { device, seconds: LISTEN_S },
                { limit: LIMIT_MS }));
        } catch (failed) {
            setError(errorText(failed));
        } finally {
            setDoing('');
        }
    };
    useEffect(() => void ask(null), []);
    return (
        <div class="tool">
            <div class="row">
                <button disabled={doing !== ''} onClick={() => void ask(null)}>
                    Examine again
                </button>
                <span role="status">{doing}</span>
            </div>
            <p class="error" role="alert">{error}</p>
            {report && <ReportView report={report} busy={doing !== ''}
                listen={(device) => void ask(device)} />}
        </div>
    );
}
