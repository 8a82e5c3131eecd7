// Before and after: the channels of an input beside those of an output.
import { useMemo, useState } from 'preact/hooks';
import { status } from '../model/store';
import type { Input, Output, Status } from '../model/status';
import { duration, protocolName, words } from '../model/words';
import { Icon } from '../parts/icons';
import { Bar, type Look, type Source } from './bar';

const inputNamed = (status: Status, name: string) =>
    status.inputs.find((one) => one.name === name);

/** Causes with which frames still come. */
const STILL_COMES = new Set(['radio_lost', 'stale', 'implausible', 'channels_missing', 'late',
    'unproved']);

function lookOfInput(input: Input | undefined): Look {
    if (!input || input.cause === 'never_seen') {
        return 'none';
    }
    return input.state !== 'failsafe' ? 'solid' : STILL_COMES.has(input.cause) ? 'ignored' : 'old';
}

function lookOfOutput(output: Output): Look {
    switch (output.state) {
        case 'control':
            return 'solid';
        case 'hold':
            return 'held';
        case 'failsafe':
            return 'preset';
        default:
            return 'old';
    }
}

const LABELS: Record<Look, string> = {
    solid: '', held: 'held', preset: 'preset', ignored: 'ignored', old: '', none: '',
};

interface CellProps extends Source {
    look: Look;
    us: number | null | undefined;
}

function Cells({ look, us, list, name, index }: CellProps) {
    const shown: Look = us == null ? 'none' : look;
    // The same elements as before are not compared again: most channels stand still.
    return useMemo(() => (
        <>
            <td class={`us ${shown}`}>
                {us == null ? <span class="none">none</span>
                    : shown === 'old' ? <s>{us}</s> : <span class="value">{us}</span>}
            </td>
            <td class="scale">
                <Bar key={name} look={shown} label={LABELS[shown]} source={{ list, name, index }} />
            </td>
        </>
    ), [shown, us, list, name, index]);
}

interface InputHeadProps {
    input: Input | undefined;
    name: string;
    look: Look;
}

function InputHead({ input, name, look }: InputHeadProps) {
    if (!input) {
        return <strong>{name}</strong>;
    }
    const state = input.cause === 'good' ? words(input.state) : words(input.cause);
    const age = input.age_us === null ? 'no frame yet' : `${duration(input.age_us)} old`;
    return (
        <>
            <strong>{input.name}</strong> {protocolName(input.protocol)}
            <small class="value" data-cause={input.cause}>
                {state}{look === 'ignored' && ', ignored'}, {input.rate_hz.toFixed(0)}/s, {age}
            </small>
        </>
    );
}

const WORDS: Record<Look, string> = {
    solid: '', held: 'held values', preset: 'presets', ignored: '', old: 'nothing is sent',
    none: '',
};

function OutputHead({ output }: { output: Output }) {
    const look = lookOfOutput(output);
    return (
        <>
            <strong>{output.name}</strong> {protocolName(output.protocol)}
            <small class="value">
                {look === 'held' && <Icon name="hold" />}
                {WORDS[look] && `${WORDS[look]}, `}
                {output.rate_hz.toFixed(0)}/s, {duration(output.lateness.p99_us)} late
            </small>
        </>
    );
}

interface ChoiceProps {
    output: Output;
    chosen: string;
    choose: (name: string) => void;
}

/** Which input stands on the left; by itself the one in control. */
function InputChoice({ output, chosen, choose }: ChoiceProps) {
    return (
        <label class="choice">Before{' '}
            <select value={chosen} onChange={(event) => choose(event.currentTarget.value)}>
                <option value="">the one in control</option>
                {output.inputs.map((name) => (
                    <option key={name} value={name}>
                        {name}{output.outvoted.includes(name) ? ' (outvoted)' : ''}
                    </option>
                ))}
            </select>
        </label>
    );
}

function Pair({ output, now }: { output: Output; now: Status }) {
    const [chosen, choose] = useState('');
    const name = chosen || output.input || output.inputs[0] || '';
    const input = inputNamed(now, name);
    const rows = Math.max(input?.channels.length ?? 0, output.channels.length);
    const inputLook = lookOfInput(input);
    const outputLook = lookOfOutput(output);
    return (
        <section class="pair" aria-label={`Channels of ${output.name}`}>
            {output.inputs.length > 1
                && <InputChoice output={output} chosen={chosen} choose={choose} />}
            <table data-pair={output.name}>
                <colgroup>
                    <col class="ch" /><col class="us" /><col /><col class="us" /><col />
                </colgroup>
                <thead>
                    <tr>
                        <th scope="col"><abbr title="channel">ch</abbr></th>
                        <th scope="col" colSpan={2}>
                            <InputHead input={input} name={name} look={inputLook} />
                        </th>
                        <th scope="col" colSpan={2}><OutputHead output={output} /></th>
                    </tr>
                </thead>
                <tbody>
                    {Array.from({ length: rows }, (_, i) => (
                        <tr key={i}>
                            <th scope="row">{i + 1}</th>
                            <Cells look={inputLook} us={input?.channels[i]}
                                list="inputs" name={name} index={i} />
                            <Cells look={outputLook} us={output.channels[i]}
                                list="outputs" name={output.name} index={i} />
                        </tr>
                    ))}
                </tbody>
            </table>
        </section>
    );
}

export function Pairs() {
    const now = status.value;
    return (
        <div class="pairs">
            {now?.outputs.map((output) => <Pair key={output.name} output={output} now={now} />)}
        </div>
    );
}
