// A recording over time: an input, an output, and the state of the output below.
import { useEffect, useState } from 'preact/hooks';
import { errorText, get } from '../model/api';
import { words } from '../model/words';
import { Plot, type Curve } from '../timing/plot';

const WIDTH = 800;
const ALL_US = 3_700_000_000;

const seconds = (us: number): string => `${(us / 1e6).toFixed(1)} s`;

interface Series {
    name: string;
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
    series: Series[];
    states: State[];
}

function curvesOf(series: Series[], channel: number): Curve[] {
    const colours = ['control', 'link', 'hold', 'text'] as const;
    return series.filter((one) => one.channel === channel).flatMap((one, i) => {
        const look = { colour: colours[i % colours.length]!, dash: i === 0 ? undefined : [6, 4] };
        return [
            { ...look, label: `${one.name} least`, values: one.least },
            { ...look, label: `${one.name} greatest`, values: one.greatest },
        ];
    });
}

export function RecordingPlot({ address }: { address: string }) {
    const [drawn, setDrawn] = useState<Drawn | null>(null);
    const [error, setError] = useState('');
    const [channel, setChannel] = useState(1);
    useEffect(() => {
        get<Drawn>(`${address}/plot?from=0&to=${ALL_US}&width=${WIDTH}`).then(
            setDrawn, (failed) => setError(errorText(failed)));
    }, []);
    if (error || !drawn) {
        return <p role="status" class={error ? 'error' : ''}>{error || 'The board reads it.'}</p>;
    }
    const count = drawn.series[0]?.least.length ?? 0;
    const step = (drawn.to_us - drawn.from_us) / Math.max(1, count) / 1e6;
    const times = Array.from({ length: count }, (_, i) => drawn.from_us / 1e6 + i * step);
    const channels = [...new Set(drawn.series.map((one) => one.channel))].sort((a, b) => a - b);
    return (
        <div>
            <label>Channel <select value={channel}
                onChange={(event) => setChannel(Number(event.currentTarget.value))}>
                {channels.map((one) => <option key={one} value={one}>{one}</option>)}
            </select></label>
            <Plot title={`Channel ${channel}`} unit="us" times={times} range={[800, 2200]}
                summary="Least and greatest of each moment, as recorded; nothing here is live."
                curves={curvesOf(drawn.series, channel)} />
            <ul class="states">{drawn.states.map((one) => (
                <li key={`${one.output}${one.from_us}`}>
                    {one.output}: {words(one.state)} from {seconds(one.from_us)} to{' '}
                    {seconds(one.to_us)}
                </li>
            ))}</ul>
        </div>
    );
}
