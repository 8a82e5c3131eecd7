import { useEffect, useState } from 'preact/hooks';
import { samplesKept, spellsKept, type Sample } from '../model/history';
import type { Distribution, Output } from '../model/status';
import { status } from '../model/store';
import { duration, sum } from '../model/words';
import { Histograms } from './histograms';
import { Plot, type Curve } from './plot';
import { Stripes } from './stripes';

const DRAWN_MS = 1000;

type Kind = 'latency' | 'lateness';

function numbers(samples: readonly Sample[], name: string, pick: (d: Distribution) => number,
                 kind: Kind): (number | null)[] {
    return samples.map((sample) => {
        const found = sample.figures?.[name]?.[kind];
        return found && found.count > 0 ? pick(found) : null;
    });
}

function distribution(samples: readonly Sample[], name: string, kind: Kind): Curve[] {
    return [
        { label: 'max', colour: 'failsafe', dash: [2, 4],
            values: numbers(samples, name, (one) => one.max_us, kind) },
        { label: 'p99', colour: 'hold', dash: [8, 4],
            values: numbers(samples, name, (one) => one.p99_us, kind) },
        { label: 'p50', colour: 'control',
            values: numbers(samples, name, (one) => one.p50_us, kind) },
    ];
}

const COLOURS = ['control', 'link', 'hold', 'text', 'failsafe'] as const;

function rates(samples: readonly Sample[], names: string[]): Curve[] {
    return names.map((name, i) => ({
        label: name, colour: COLOURS[i % COLOURS.length]!,
        dash: i === 0 ? undefined : [4 + 3 * i, 4],
        values: samples.map((sample) => sample.figures?.[name]?.rate ?? null),
    }));
}

/** Losses since the sample before; none across a gap. */
function losses(samples: readonly Sample[], names: string[]): Curve[] {
    return names.map((name, i) => ({
        label: name, colour: COLOURS[i % COLOURS.length]!,
        dash: i === 0 ? undefined : [4 + 3 * i, 4],
        values: samples.map((sample, at) => {
            const now = sample.figures?.[name]?.lost;
            const before = samples[at - 1]?.figures?.[name]?.lost;
            return now === undefined || before === undefined ? null : Math.max(0, now - before);
        }),
    }));
}

function said(one: Distribution): string {
    return `p50 ${duration(one.p50_us)}, p99 ${duration(one.p99_us)}, `
        + `at most ${duration(one.max_us)}`;
}

/** The figures of now, for all outputs. */
function Figures({ outputs }: { outputs: Output[] }) {
    const cells = (one: Distribution) => [one.p50_us, one.p99_us, one.max_us].map((us, i) =>
        <td key={i}><span class="value">{one.count > 0 ? duration(us) : 'none'}</span></td>);
    return (
        <div class="scroll" tabIndex={0} role="region" aria-label="Figures of now">
            <table class="figures">
                <thead><tr>
                    <th scope="col">output</th><th scope="col">figure</th><th scope="col">p50</th>
                    <th scope="col">p99</th><th scope="col">max</th><th scope="col">missed</th>
                    <th scope="col">dropped</th>
                </tr></thead>
                <tbody>{outputs.flatMap((one) => [
                    <tr key={`${one.name} latency`}>
                        <th scope="row">{one.name}</th><td>latency</td>{cells(one.latency)}
                        <td><span class="value">{one.deadline_misses}</span></td>
                        <td><span class="value">{sum(one.dropped)}</span></td>
                    </tr>,
                    <tr key={`${one.name} lateness`}>
                        <th scope="row">{one.name}</th><td>lateness</td>{cells(one.lateness)}
                        <td /><td />
                    </tr>,
                ])}</tbody>
            </table>
        </div>
    );
}

function useSeconds(): number {
    const [now, setNow] = useState(performance.now());
    useEffect(() => {
        const timer = setInterval(() => setNow(performance.now()), DRAWN_MS);
        return () => clearInterval(timer);
    }, []);
    return now / 1000;
}

export function TimingScreen() {
    const now = useSeconds();
    const [chosen, choose] = useState('');
    const outputs = status.value?.outputs ?? [];
    const output = outputs.find((one) => one.name === chosen) ?? outputs[0];
    const samples = samplesKept();
    if (!output || samples.length === 0) {
        return <p class="empty">No data yet. The page collects while it is open and hears the board:
            ten minutes at most.</p>;
    }
    const times = samples.map((sample) => Math.round((sample.at - now) * 10) / 10);
    const name = `output ${output.name}`;
    const inputs = status.value?.inputs.map((one) => `input ${one.name}`) ?? [];
    const all = [...inputs, ...outputs.map((one) => `output ${one.name}`)];
    return (
        <div class="timing">
            <Figures outputs={outputs} />
            {outputs.length > 1 && (
                <label>Output <select value={output.name}
                    onChange={(event) => choose(event.currentTarget.value)}>
                    {outputs.map((one) => <option key={one.name}>{one.name}</option>)}
                </select></label>
            )}
            <Plot title={`Latency of ${output.name}`} unit="us" times={times}
                summary={`Now ${said(output.latency)}.`}
                curves={distribution(samples, name, 'latency')} />
            <Plot title={`Lateness of ${output.name}`} unit="us" times={times}
                summary={`Now ${said(output.lateness)}.`}
                curves={distribution(samples, name, 'lateness')} />
            <Plot title="Rate" unit="frames/s" times={times} summary="Frames in a second."
                curves={rates(samples, all)} />
            <Plot title="Losses, rejected, missed and dropped" unit="in a second" times={times}
                summary="How many began or happened in each second."
                curves={losses(samples, all)} />
            <Histograms output={output.name} />
            <Stripes spells={spellsKept()} now={now} />
        </div>
    );
}
