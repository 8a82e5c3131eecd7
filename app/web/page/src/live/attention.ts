// What a person must look at besides the outputs themselves, in words.
import type { Port, Status, Value } from '../model/status';
import { duration, inputText } from '../model/words';

const isFine = (port: Port): boolean =>
    port.present && (port.can == null || port.can.state === 'ready');

/** Inputs that are not good, except those that the sentence of an output names already. */
function inputProblems(status: Status): string[] {
    const named = new Set(status.outputs
        .filter((output) => output.state !== 'control')
        .flatMap((output) => output.inputs));
    return status.inputs
        .filter((input) => input.cause !== 'good' && !named.has(input.name))
        .map((input) => `${input.name}: ${inputText(input)}`);
}

function valueText(value: Value): string {
    const age = value.age_us === null ? '' : `, ${duration(value.age_us)} old`;
    return `${value.name}: ${value.text}${age}`;
}

export function attention(status: Status): string[] {
    return [
        ...inputProblems(status),
        ...status.ports.filter((port) => !isFine(port))
            .map((port) => `${port.can ? 'CAN ' : ''}${port.name}: ${port.text}`),
        ...status.lines.filter((line) => !line.present)
            .map((line) => `GPIO ${line.name}: ${line.text}`),
        ...status.dronecan.filter((node) => node.state !== 'online')
            .map((node) => `DroneCAN on ${node.interface}: ${node.text}`),
        ...status.values.filter((value) => value.stale).map(valueText),
        status.machine.undervoltage ? 'The supply voltage of the board is too low' : '',
        ...status.missing_realtime.map((missing) => `Real time: ${missing}`),
    ].filter((text) => text !== '');
}
