// Keeps one stream of the shown daemon open while the page is visible, and judges its age.
import { effect } from '@preact/signals';
import { unpaired } from './api';
import { openStream, type ServerEvent } from './events';
import { Judge, RECONNECT_MS, type LinkState } from './freshness';
import { daemonName, freshness, newest, status, streamEnded } from './store';
import { remember } from './history';
import type { Status } from './status';
import { watchTrial } from './trial';

const TICK_MS = 50;
const TEXT_MS = 240;
const RATE = 10;
const KNOWN_VERSION = 1;
/** A daemon of another age may lack a list. */
const EMPTY = {
    inputs: [], outputs: [], ports: [], lines: [], sensor_buses: [], dronecan: [], values: [],
    missing_realtime: [], machine: {},
};

let judge = new Judge();
let link: LinkState = { kind: 'opening' };
let close: (() => void) | null = null;
let openedAt = 0;
let textAt = 0;
let textShape = '';

/** Whatever a person must see at once. */
function shapeOf(news: Status): string {
    const inputs = news.inputs.map((one) => `${one.name},${one.state},${one.cause}`);
    const outputs = news.outputs.map((one) =>
        `${one.name},${one.state},${one.input},${one.text},${one.outvoted}`);
    const ports = news.ports.map((one) => `${one.present},${one.can?.state}`);
    return [...inputs, ...outputs, ...ports, news.trial].join(';');
}

function show(news: Status): void {
    const now = performance.now();
    judge.arrived(news, now, Date.now());
    link = { kind: 'open' };
    newest.value = news;
    const shape = shapeOf(news);
    if (shape !== textShape || now - textAt >= TEXT_MS) {
        textShape = shape;
        textAt = now;
        status.value = news;
    }
    tick();
    watchTrial(news);
    remember(news, freshness.value.level === 'live', now);
}

function parsed<T>(event: ServerEvent): T | null {
    try {
        return JSON.parse(event.data) as T;
    } catch {
        return null;
    }
}

function take(events: ServerEvent[]): void {
    // What waited in the network is old; only the newest status counts.
    const last = events.findLast((event) => event.name === 'status');
    for (const event of events) {
        if (event === last) {
            takeStatus(event);
        } else if (event.name !== 'status') {
            takeNotice(event);
        }
    }
}

function takeStatus(event: ServerEvent): void {
    const news = parsed<Status>(event);
    if (news && news.version === KNOWN_VERSION) {
        try {
            show({ ...EMPTY, ...news });
        } catch (error) {
            link = { kind: 'gone', reason: `its status cannot be shown (${String(error)})` };
        }
    } else if (news) {
        link = { kind: 'gone', reason: 'it speaks another version than this page; load it again' };
    }
}

function takeNotice(event: ServerEvent): void {
    const reason = parsed<{ reason?: string }>(event)?.reason ?? 'no reason was given';
    if (event.name === 'gone') {
        link = { kind: 'gone', reason };
        // The server is there: the stream goes on and needs no new connection.
        openedAt = performance.now();
    } else if (event.name === 'ended') {
        link = { kind: 'ended', reason };
        streamEnded.value = true;
        stop();
    } else if (event.name === 'revoked') {
        unpaired.value = true;
    }
    tick();
}

function start(): void {
    stop();
    openedAt = performance.now();
    judge.connected();
    close = openStream(`/api/${encodeURIComponent(daemonName.value)}/stream?rate=${RATE}`, {
        events: take,
        end: ended,
    });
}

function ended(code: number, text: string): void {
    close = null;
    if (code === 401) {
        unpaired.value = true;
    } else if (code >= 400) {
        link = { kind: 'gone', reason: text || `the server answers ${code}` };
    } else if (code === 0) {
        link = { kind: 'opening', why: ' The board cannot be reached.' };
    }
    tick();
}

function stop(): void {
    close?.();
    close = null;
}

function wanted(): boolean {
    return daemonName.value !== '' && !unpaired.value && !streamEnded.value && !document.hidden;
}

/** Opens the stream again 3 s after the last sign of it, also if the server only stays silent. */
function watchStream(now: number): void {
    if (!wanted()) {
        return;
    }
    const silence = judge.silence(now, Date.now()) ?? Infinity;
    const late = Math.max(silence, judge.delay());
    if (now - openedAt > RECONNECT_MS && late > RECONNECT_MS) {
        start();
    }
}

function tick(): void {
    const now = performance.now();
    watchStream(now);
    const next = judge.judge(link, now, Date.now());
    const before = freshness.peek();
    if (next.level !== before.level || next.text !== before.text || next.short !== before.short) {
        freshness.value = next;
    }
}

/** A fifth page took the place of this one, and the person wants it back. */
export function goOn(): void {
    streamEnded.value = false;
    link = { kind: 'opening' };
    start();
}

function look(): void {
    if (document.hidden) {
        link = { kind: 'hidden' };
        stop();
    } else if (wanted()) {
        link = { kind: 'opening' };
        start();
    }
    tick();
}

export function keepConnected(): void {
    let shown = '';
    effect(() => {
        const name = daemonName.value;
        const open = name !== '' && !unpaired.value;
        if (name !== shown) {
            shown = name;
            judge = new Judge();
            newest.value = null;
            status.value = null;
            link = { kind: 'opening' };
        }
        if (!open) {
            stop();
        } else if (!document.hidden && !streamEnded.peek()) {
            // Not again when the page goes on: two streams would take the places of two pages.
            start();
        }
    });
    document.addEventListener('visibilitychange', look);
    // A page that comes back from the browser's memory lost its stream without a word.
    addEventListener('pagehide', () => {
        link = { kind: 'hidden' };
        stop();
        tick();
    });
    addEventListener('pageshow', (event) => event.persisted && look());
    setInterval(tick, TICK_MS);
    tick();
}
