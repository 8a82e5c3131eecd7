// One channel on a scale from 800 to 2200 us.
import { useSignalEffect } from '@preact/signals';
import { useRef } from 'preact/hooks';
import { newest } from '../model/store';
import type { Input, Output, Status } from '../model/status';

const LEAST_US = 800;
const MOST_US = 2200;

/**
 * solid: it counts; held: last values; preset: failsafe values; ignored: it comes, but does not
 * count; old: it came once; none: there is no value.
 */
export type Look = 'solid' | 'held' | 'preset' | 'ignored' | 'old' | 'none';

/** Where on the scale, 0 to 1. */
export function position(us: number): number {
    return Math.min(1, Math.max(0, (us - LEAST_US) / (MOST_US - LEAST_US)));
}

/** One channel of an input or output. */
export interface Source {
    list: 'inputs' | 'outputs';
    name: string;
    index: number;
}

function pulseOf(status: Status, { list, name, index }: Source): number | null {
    const all: (Input | Output)[] = status[list];
    return all.find((one) => one.name === name)?.channels[index] ?? null;
}

interface BarProps {
    look: Look;
    label: string;
    source: Source;
}

export function Bar({ look, label, source }: BarProps) {
    const fill = useRef<HTMLDivElement>(null);
    const drawn = useRef<number | null>(null);
    // Only the strip moves, and only if its channel did: nothing else is drawn for each event.
    useSignalEffect(() => {
        const now = newest.value;
        const us = now && pulseOf(now, source);
        const strip = fill.current;
        if (strip && us !== drawn.current) {
            drawn.current = us;
            const share = us === null ? 0 : position(us);
            strip.style.transform = `translateX(${(share * 100 - 100).toFixed(2)}%)`;
        }
    });
    return (
        <div class={`bar ${look}`} aria-hidden="true">
            <div class="groove"><div class="fill" ref={fill} /></div>
            <i class="end low" /><i class="end middle" /><i class="end high" />
            {label && <span class="label">{label}</span>}
        </div>
    );
}
