// Whole distributions of times as bars: the daemon counts them, the page asks for them now and then.
import { useEffect, useState } from 'preact/hooks';
import { errorText, get } from '../model/api';
import { api } from '../model/store';
import { duration } from '../model/words';

const ASK_MS = 5000;
const HEIGHT = 100;
const BAR = 10;

interface Reading {
    counts: number[];
    max_us: number;
}

interface Part {
    name: string;
    latency: Record<Period, Reading>;
    lateness: Record<Period, Reading>;
}

interface Answer {
    starts_us: number[];
    outputs: Part[];
}

type Period = 'last_minute' | 'since_start';

/** The end of a bucket: the last one has none. */
const endOf = (starts: number[], bucket: number): string =>
    bucket + 1 < starts.length ? duration(starts[bucket + 1]!) : 'more';

function Bars({ title, starts, reading }: {
    title: string; starts: number[]; reading: Reading;
}) {
    const { counts } = reading;
    const all = counts.reduce((sum, one) => sum + one, 0);
    if (all === 0) {
        return (
            <figure class="figure">
                <figcaption>{title}</figcaption>
                <p class="quiet">No frame in this time.</p>
            </figure>
        );
    }
    const most = Math.max(...counts);
    const first = counts.findIndex((one) => one > 0);
    const used = counts.slice(first);
    const mode = counts.indexOf(most);
    const said = `${all} frames, most from ${duration(starts[mode]!)} to ${endOf(starts, mode)}, `
        + `at most ${duration(reading.max_us)}`;
    const height = (count: number) => HEIGHT * Math.log1p(count) / Math.log1p(most);
    return (
        <figure class="figure histogram">
            <figcaption>{title}</figcaption>
            <svg viewBox={`0 0 ${used.length * BAR} ${HEIGHT}`} preserveAspectRatio="none"
                role="img" aria-label={`${title}. ${said}.`}>
                {used.map((count, i) => (
                    <rect key={i} x={i * BAR + 1} width={BAR - 2} y={HEIGHT - height(count)}
                        height={height(count)}>
                        <title>{`${duration(starts[first + i]!)} to `
                            + `${endOf(starts, first + i)}: ${count}`}</title>
                    </rect>
                ))}
            </svg>
            <p class="ends quiet" aria-hidden="true">
                <span>{duration(starts[first]!)}</span>
                <span>{endOf(starts, first + used.length - 1)}</span>
            </p>
            <p class="quiet"><span class="value">{said}.</span></p>
        </figure>
    );
}

export function Histograms({ output }: { output: string }) {
    const [answer, setAnswer] = useState<Answer | null>(null);
    const [error, setError] = useState('');
    const [period, setPeriod] = useState<Period>('last_minute');
    useEffect(() => {
        let gone = false;
        const take = (news: Answer | null, why: string) => {
            if (!gone) {
                setAnswer(news);
                setError(why);
            }
        };
        const ask = () => {
            if (!document.hidden) {
                get<Answer>(api('histograms')).then((news) => take(news, ''),
                    (failed) => take(null, errorText(failed)));
            }
        };
        ask();
        const timer = setInterval(ask, ASK_MS);
        return () => {
            gone = true;
            clearInterval(timer);
        };
    }, []);
    const part = answer?.outputs.find((one) => one.name === output);
    return (
        <section class="histograms" aria-label="Distributions">
            <h2>Distributions</h2>
            <label>Frames of <select value={period}
                onChange={(event) => setPeriod(event.currentTarget.value as Period)}>
                <option value="last_minute">the last minute</option>
                <option value="since_start">all since the start</option>
            </select></label>
            {!part && <p role="status" class={error ? 'error' : ''}>
                {error || 'Waiting for the board.'}</p>}
            {part && answer && (
                <div class="sides">
                    <Bars title={`Latency of ${output}`} starts={answer.starts_us}
                        reading={part.latency[period]} />
                    <Bars title={`Lateness of ${output}`} starts={answer.starts_us}
                        reading={part.lateness[period]} />
                </div>
            )}
            <p class="quiet">Each bar is a span of time, a quarter longer than the one before. Its
                height grows with the logarithm of the count, so that single frames are seen.</p>
        </section>
    );
}
