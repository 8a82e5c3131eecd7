// A plot over time; uPlot is loaded when the first one is shown.
import { useEffect, useRef, useState } from 'preact/hooks';
import type uPlot from 'uplot';
import { theme } from '../model/store';

export interface Curve {
    label: string;
    /** null: nothing was there, and no line is drawn across. */
    values: (number | null)[];
    /** Curves are told apart by their dashes too, not by colour alone. */
    dash?: number[];
    colour: 'control' | 'hold' | 'failsafe' | 'link' | 'text';
    width?: number;
}

interface PlotProps {
    title: string;
    /** What the plot shows, for who does not see it. */
    summary: string;
    unit: string;
    times: number[];
    curves: Curve[];
    range?: [number, number];
    height?: number;
}

const colourOf = (name: string): string =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

let styled = false;

/** The style of uPlot is a file of its own, because the page allows no other styles. */
function addStyle(): void {
    const address = document.body.dataset.plotStyle;
    if (!styled && address) {
        styled = true;
        const link = document.createElement('link');
        link.rel = 'stylesheet';
        link.href = address;
        document.head.append(link);
    }
}

function optionsOf(props: PlotProps, width: number): uPlot.Options {
    const axis = {
        stroke: colourOf('quiet'),
        grid: { stroke: colourOf('line'), width: 1 },
        ticks: { stroke: colourOf('line'), width: 1 },
    };
    return {
        width,
        height: props.height ?? 220,
        scales: { x: { time: false }, y: props.range ? { range: props.range } : {} },
        axes: [{ ...axis, values: (_, all) => all.map((at) => `${at} s`) },
            { ...axis, size: 64 }],
        series: [
            { label: 's' },
            ...props.curves.map((one) => ({
                label: `${one.label}, ${props.unit}`,
                stroke: colourOf(one.colour),
                width: one.width ?? 2,
                dash: one.dash,
                spanGaps: false,
                points: { show: false },
            })),
        ],
        cursor: { drag: { x: false, y: false } },
    };
}

export function Plot(props: PlotProps) {
    const host = useRef<HTMLDivElement>(null);
    const made = useRef<uPlot | null>(null);
    const [library, setLibrary] = useState<typeof uPlot | null>(null);
    const [failed, setFailed] = useState(false);
    const data = [props.times, ...props.curves.map((one) => one.values)] as uPlot.AlignedData;
    const shape = props.curves.map((one) => one.label).join('\n') + theme.value;
    useEffect(() => {
        addStyle();
        import('uplot').then((part) => setLibrary(() => part.default), () => setFailed(true));
    }, []);
    useEffect(() => {
        const place = host.current;
        if (!library || !place) {
            return undefined;
        }
        const plot = new library(optionsOf(props, place.clientWidth), data, place);
        made.current = plot;
        const watch = new ResizeObserver(() =>
            plot.setSize({ width: place.clientWidth, height: props.height ?? 220 }));
        watch.observe(place);
        return () => {
            watch.disconnect();
            plot.destroy();
            made.current = null;
        };
    }, [library, shape]);
    useEffect(() => made.current?.setData(data), [props.times, props.curves]);
    return (
        <figure class="figure">
            <figcaption>{props.title}, {props.unit}</figcaption>
            <div class="plot" ref={host} role="img" aria-label={`${props.title}. ${props.summary}`}>
                {failed && <p>The plot did not arrive. Load the page again.</p>}
            </div>
        </figure>
    );
}
