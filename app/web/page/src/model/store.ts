// What all screens share.
import { computed, effect, signal } from '@preact/signals';
import type { Freshness } from './freshness';
import { duration } from './words';
import type { Daemon, Me, Status } from './status';

export const SCREENS = [
    'live', 'timing', 'config', 'doctor', 'learn', 'recordings', 'more',
] as const;
export type Screen = typeof SCREENS[number];

export const me = signal<Me | null>(null);
export const daemons = signal<Daemon[] | null>(null);
/** Changes with every event: for bars. */
export const newest = signal<Status | null>(null);
/** Changes at most four times a second, and at once when a state changes: for text. */
export const status = signal<Status | null>(null);
export const freshness = signal<Freshness>({ level: 'stale', short: 'connecting', text: '' });
/** The server ended the stream because this browser has too many pages open. */
export const streamEnded = signal(false);

/** The list is asked for each 5 s, and an answer may take 5 s. */
const LIST_OLD_S = 11;

/** Whether the server can fill this screen. */
export function offers(one: Screen): boolean {
    return me.value?.screens?.includes(one) ?? true;
}

export const mayChange = computed(() => me.value?.role === 'change');

// The address: #/DAEMON/SCREEN

export interface Route {
    daemon: string;
    screen: Screen;
}

function readRoute(): Route {
    const [, daemon = '', screen = ''] = location.hash.split('/');
    let name = '';
    try {
        name = decodeURIComponent(daemon);
    } catch {
        // A damaged address leads to the first daemon.
    }
    return { daemon: name, screen: SCREENS.find((one) => one === screen) ?? 'live' };
}

const asked = signal<Route>(readRoute());
addEventListener('hashchange', () => {
    asked.value = readRoute();
});

export const route = computed<Route>(() => {
    const list = daemons.value ?? [];
    const known = list.find((one) => one.name === asked.value.daemon);
    const shown = offers(asked.value.screen) ? asked.value.screen : 'live';
    return { daemon: (known ?? list[0])?.name ?? '', screen: shown };
});
export const daemonName = computed(() => route.value.daemon);
export const screen = computed(() => route.value.screen);
export const daemon = computed(() => daemons.value?.find((one) => one.name === daemonName.value));
/** How old the list of daemons is, in whole seconds. */
export const listAgeS = signal(0);
const listedAbsent = computed(() =>
    daemon.value?.state === 'absent' && freshness.value.level !== 'live');
/** An old list shows nothing, and a live stream knows better. */
export const absent = computed(() => listedAbsent.value && listAgeS.value <= LIST_OLD_S);
/** While the server is not heard: what it said last. */
export const lastListed = computed(() => listedAbsent.value && !absent.value
    ? ` ${duration(listAgeS.value * 1e6)} ago no daemon ran; whether one runs now is not known.`
    : '');

export function addressOf(screenName: Screen, name: string = daemonName.value): string {
    return `#/${encodeURIComponent(name)}/${screenName}`;
}

/** The address of something of the daemon that is shown. */
export function api(rest: string): string {
    return `/api/${encodeURIComponent(daemonName.value)}/${rest}`;
}

// Dark or light

export const THEMES = ['system', 'light', 'dark'] as const;
export type Theme = typeof THEMES[number];

function savedTheme(): Theme {
    try {
        return THEMES.find((one) => one === localStorage.getItem('theme')) ?? 'system';
    } catch {
        return 'system';
    }
}

export const theme = signal<Theme>(savedTheme());
effect(() => {
    document.documentElement.dataset.theme = theme.value;
    try {
        localStorage.setItem('theme', theme.value);
    } catch {
        // A browser that keeps nothing shows the choice until the page is left.
    }
});
