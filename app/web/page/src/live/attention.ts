// What a person must look at besides the outputs themselves, in words.
import type { Port, Status } from '../model/status';
import { duration, inputText, words } from '../model/words';

function portProblem(port: Port): string {
    if (!port.present) {
        return `${port.name}: is gone; waiting for it`;
    }
    const state = port.can?.state ?? 'ready';
    return state === 'ready' ? '' : `CAN ${port.name}: ${words(state)}`;
}

/** Inputs that are not good, except those that the sentence of an output names already. */
function inputProblems(status: Status): string[] {
    const named = new Set(status.outputs
        .filter((output) => output.state !== 'control')
        .flatMap((output) => output.inputs));
    return status.inputs
        .filter((input) => input.cause !== 'good' && !named.has(input.name))
        .map((input) => `${input.name}: ${inputText(input)}`);
}

function valueProblems(status: Status): string[] {
    return status.values.filter((value) => value.stale).map((value) => value.age_us === null
        ? `${value.name}: never seen`
        : `${value.name}: stale, ${duration(value.age_us)} old`);
}

export function attention(status: Status): string[] {
    return [
        ...inputProblems(status),
        ...status.ports.map(portProblem),
        ...status.lines.filter((line) => !line.present)
            .map((line) => `GPIO ${line.name}: its chip is gone`),
        ...status.dronecan.filter((node) => node.state !== 'online')
            .map((node) => `DroneCAN on ${node.interface}: ${words(node.state)}`),
        ...valueProblems(status),
        status.machine.undervoltage ? 'The supply voltage of the board is too low' : '',
        ...status.missing_realtime.map((missing) => `Real time: ${missing}`),
    ].filter((text) => text !== '');
}
