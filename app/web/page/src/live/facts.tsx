// Inputs, buses, lines, sensors and values: small, below the channels.
import type { ComponentChildren } from 'preact';
import { status } from '../model/store';
import type { Can, Input, Machine, Port, SensorBus, Status, Value } from '../model/status';
import { duration, inputText, protocolName, sum, words } from '../model/words';

interface FactProps {
    name: string;
    children: ComponentChildren;
    bad?: boolean;
}

function Fact({ name, children, bad }: FactProps) {
    return (
        <div class={bad ? 'fact bad' : 'fact'}>
            <dt>{name}</dt>
            <dd class="value">{children}</dd>
        </div>
    );
}

function Group({ title, children }: { title: string; children: ComponentChildren[] }) {
    return children.length === 0 ? null : (
        <section class="group"><h2>{title}</h2><dl>{children}</dl></section>
    );
}

/** "controls servos", "outvoted for servos" */
function roleOf(input: Input, now: Status): string {
    const roles = now.outputs.flatMap((output) => [
        output.state === 'control' && output.input === input.name ? `controls ${output.name}` : '',
        output.outvoted.includes(input.name) ? `outvoted for ${output.name}` : '',
    ]);
    return roles.filter((one) => one !== '').join(', ');
}

function inputFact(input: Input, now: Status) {
    const role = roleOf(input, now);
    const age = input.age_us === null ? '' : `, newest frame ${duration(input.age_us)} old`;
    return (
        <Fact key={input.name} name={`${input.name}, ${protocolName(input.protocol)}`}
            bad={input.cause !== 'good'}>
            {inputText(input)}{role && <b>, {role}</b>}, {input.rate_hz.toFixed(1)}/s{age},{' '}
            rejected {sum(input.rejected)} <small>{input.port}</small>
        </Fact>
    );
}

function canCounts(can: Can): string {
    return `, received ${can.received}, sent ${can.sent}, `
        + `errors ${can.error_frames}, bus-offs ${can.bus_offs}`;
}

function portFact(port: Port) {
    const bad = !port.present || (port.can != null && port.can.state !== 'ready');
    return (
        <Fact key={port.name} name={port.kind === 'can' ? `CAN ${port.name}` : port.name} bad={bad}>
            {port.text}{port.can ? canCounts(port.can) : ''}
        </Fact>
    );
}

function busCounts(bus: SensorBus): string {
    const { counts } = bus;
    return bus.role === 'receiver'
        ? `, replies ${counts.replies ?? 0}, misses ${counts.misses ?? 0}`
        : `, answered ${counts.answered ?? 0}, late ${counts.late ?? 0}`;
}

function valueFact(value: Value) {
    const age = value.age_us === null ? '' : `${duration(value.age_us)} old`;
    return (
        <Fact key={value.name} name={value.name} bad={value.stale}>
            {value.text} <small>{age}</small>
        </Fact>
    );
}

const amount = (number: number | null | undefined, unit: string): string | null =>
    number == null ? null : `${Number(number.toPrecision(4))} ${unit}`;

function machineFacts(machine: Machine) {
    const facts: [string, string | null][] = [
        ['temperature', amount(machine.temperature_degC, '°C')],
        ['load', amount(machine.load_percent, '%')],
        ['memory', amount(machine.memory_percent, '%')],
        ['supply', amount(machine.supply_V, 'V')],
        ['undervoltage', machine.undervoltage ? 'yes' : null],
    ];
    return facts.flatMap(([name, text]) => text === null ? []
        : [<Fact key={name} name={name} bad={name === 'undervoltage'}>{text}</Fact>]);
}

export function Facts() {
    const now = status.value;
    if (!now) {
        return null;
    }
    return (
        <div class="facts">
            <Group title="Inputs">{now.inputs.map((input) => inputFact(input, now))}</Group>
            <Group title="Ports">{now.ports.map(portFact)}</Group>
            <Group title="GPIO">
                {now.lines.map((line) => (
                    <Fact key={line.name} name={line.name} bad={!line.present}>
                        {line.text}, {words(line.role)} {line.line}
                    </Fact>
                ))}
            </Group>
            <Group title="Sensor buses">
                {now.sensor_buses.map((bus) => (
                    <Fact key={bus.name} name={`${bus.name}, ${bus.role}`}>
                        {bus.text}{busCounts(bus)}
                    </Fact>
                ))}
            </Group>
            <Group title="DroneCAN">
                {now.dronecan.map((node) => (
                    <Fact key={node.interface} name={node.interface} bad={node.state !== 'online'}>
                        {node.text}, errors {node.errors}
                    </Fact>
                ))}
            </Group>
            <Group title="Values">{now.values.map(valueFact)}</Group>
            <Group title="Machine">{machineFacts(now.machine)}</Group>
        </div>
    );
}
