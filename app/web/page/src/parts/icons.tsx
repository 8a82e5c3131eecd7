// Icons are drawn here: a font of the browser may lack them. Each stands beside a word.

const PATHS = {
    control: 'M4 12l5 5L20 6',
    hold: 'M12 3a9 9 0 1 0 .01 0zM12 7v5l3 2',
    failsafe: 'M12 3L2.5 20h19zM12 9v5M12 16.5v1',
    silent: 'M5 5l14 14M19 5L5 19',
    waiting: 'M4 12h2M11 12h2M18 12h2',
    live: 'M2 12h4l3-7 5 14 3-7h5',
    timing: 'M4 20V10M10 20V4M16 20v-7M22 20H2',
    config: 'M4 6h16M4 12h10M4 18h13',
    more: 'M5 12h.01M12 12h.01M19 12h.01',
    colours: 'M12 3a9 9 0 1 0 .01 0zM12 3v18M15 5v14M18 7v10',
    note: 'M12 3a9 9 0 1 0 .01 0zM12 11v6M12 7v1',
} as const;
export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
    return (
        <svg class="icon" viewBox="0 0 24 24" aria-hidden="true" focusable="false">
            <path d={PATHS[name]} />
        </svg>
    );
}
