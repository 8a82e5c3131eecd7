// A recording over time: an input, an output, and the state of the output below.
import { useEffect, useState } from 'preact/hooks';
import { errorText, get, statusOf } from '../model/api';
import { words } from '../model/words';
import { Plot, type Curve } from '../timing/plot';

const WIDTH = 800;
const ALL_US = 3_700_000_000;
/** Longer than the server lets its reader take. */
const PATIENCE_MS = 30_000;
const AGAIN_MS = 1000;
const BUSY = 503;
const LEAST_US = 10_000;

const seconds = (us: number): string => `${(us / 1e6).toFixed(1)} s`;

/** From and to, in microseconds. */
type Range = [number, number];

/** The board reads one recording at a time. Nothing when nobody waits for it any more. */
async function plotOf(address: string, [from, to]: Range, wanted: () => boolean) {
    while (wanted()) {
        try {
            return await get<Drawn>(`${address}/plot?from=${from}&to=${to}&width=${WIDTH}`,
                PATIENCE_MS);
        } catch (error) {
            if (statusOf(error) !== BUSY) {
                throw error;
            }
            await new Promise((done) => setTimeout(done, AGAIN_MS));
        }
    }
    return null;
}

/** A range of another length around the same middle, or one beside it, within the recording. */
function moved(drawn: Drawn, zoom: number, shift: number): Range {
    const before = drawn.to_us - drawn.from_us;
    const span = Math.min(drawn.length_us, Math.max(LEAST_US, before * zoom));
    const middle = (drawn.from_us + drawn.to_us) / 2 + before * shift;
    const from = Math.max(0, Math.min(drawn.length_us - span, middle - span / 2));
    return [Math.floor(from), Math.ceil(from + span)];
}

interface Series {
    name: string;
    kind: 'input' | 'output';
    channel: number;
    least: (number | null)[];
    greatest: (number | null)[];
}

interface State {
    output: string;
    from_us: number;
    to_us: number;
    state: string;
}

interface Drawn {
    from_us: number;
    to_us: number;
    length_us: number;
    problem: string | null;
    states_left_out: number;
    series: Series[];
    states: State[];
}

function curvesOf(series: Series[], channel: number): Curve[] {
    const colours = ['control', 'link', 'hold', 'text'] as const;
    return series.filter((one) => one.channel === channel).flatMap((one, i) => {
        const look = { colour: colours[i % colours.length]!, dash: i === 0 ? undefined : [6, 4] };
        return [
            { ...look, label: `${one.kind} ${one.name} least`, values: one.least },
            { ...look, label: `${one.kind} ${one.name} greatest`, values: one.greatest },
        ];
    });
}

export function RecordingPlot({ address }: { address: string }) {
    const [drawn, setDrawn] = useState<Drawn | null>(null);
    const [error, setError] = useState('');
    const [channel, setChannel] = useState(1);
    const [range, setRange] = useState<Range>([0, ALL_US]);
    useEffect(() => {
        let gone = false;
        plotOf(address, range, () => !gone).then((plot) => !gone && setDrawn(plot),
            (failed) => !gone && setError(errorText(failed)));
        return () => { gone = true; };
    }, [range]);
    if (error || !drawn) {
        return <p role="status" class={error ? 'error' : ''}>{error || 'The board reads it.'}</p>;
    }
    const count = drawn.series[0]?.least.length ?? 0;
    const step = (drawn.to_us - drawn.from_us) / Math.max(1, count) / 1e6;
    const times = Array.from({ length: count }, (_, i) => drawn.from_us / 1e6 + i * step);
    const channels = [...new Set(drawn.series.map((one) => one.channel))].sort((a, b) => a - b);
    const look = (name: string, zoom: number, shift: number) => (
        <button onClick={() => setRange(moved(drawn, zoom, shift))}>{name}</button>
    );
    return (
        <div>
            {drawn.problem && <p class="error" role="alert">
                The recording is damaged; this is what could be read: {drawn.problem}</p>}
            <label>Channel <select value={channel}
                onChange={(event) => setChannel(Number(event.currentTarget.value))}>
                {channels.map((one) => <option key={one} value={one}>{one}</option>)}
            </select></label>
            <Plot title={`Channel ${channel}`} unit="us" times={times} range={[800, 2200]}
                summary="Least and greatest of each moment, as recorded; nothing here is live."
                curves={curvesOf(drawn.series, channel)} />
            <div class="row">
                {look('Earlier', 1, -0.5)}{look('Later', 1, 0.5)}
                {look('Closer', 0.5, 0)}{look('Further', 2, 0)}
                <span>{seconds(drawn.from_us)} to {seconds(drawn.to_us)} of{' '}
                    {seconds(drawn.length_us)}</span>
            </div>
            <p class="quiet">The values passed the ports. The states are those of the recorded
                configuration, run again over the recorded inputs; GPIO lines are not recorded.</p>
            <ul class="states">{drawn.states.map((one) => (
                <li key={`${one.output}${one.from_us}`}>
                    {one.output}: {one.state === 'unknown' ? 'not known' : words(one.state)}
                    {' '}from {seconds(one.from_us)} to {seconds(one.to_us)}
                </li>
            ))}</ul>
            {drawn.states_left_out > 0 && <p>And {drawn.states_left_out} more.</p>}
        </div>
    );
}
