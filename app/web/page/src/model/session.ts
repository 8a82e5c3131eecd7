// Who this browser is to the server, and which daemons there are.
import { signal } from '@preact/signals';
import { errorText, get, post, unpaired } from './api';
import { daemons, listAgeS, me } from './store';
import type { Daemon, Me } from './status';

const LOOK_MS = 5000;
const TICK_MS = 500;

let listedAt = { now: 0, wall: 0 };

/** Why the server told nothing, until it does. */
export const sessionError = signal('');

async function look(): Promise<void> {
    if (document.hidden) {
        return;
    }
    try {
        const answer = await get<Me>('/api/me', LOOK_MS);
        if (JSON.stringify(answer) !== JSON.stringify(me.peek())) {
            me.value = answer;
        }
        unpaired.value = answer.role === null;
        if (answer.role !== null) {
            const list = (await get<{ daemons: Daemon[] }>('/api/daemons', LOOK_MS)).daemons;
            if (JSON.stringify(list) !== JSON.stringify(daemons.peek())) {
                daemons.value = list;
            }
            listedAt = { now: performance.now(), wall: Date.now() };
            tellAge();
        }
        sessionError.value = '';
    } catch (error) {
        sessionError.value = errorText(error);
    }
}

/** performance.now() stands still while some machines sleep, the wall clock does not. */
function tellAge(): void {
    const age = Math.max(performance.now() - listedAt.now, Date.now() - listedAt.wall);
    listAgeS.value = Math.floor(age / 1000);
}

export async function pair(code: string, name: string): Promise<void> {
    await post('/pair', { code, name });
    unpaired.value = false;
    await look();
}

export async function leave(): Promise<void> {
    await post('/leave', {});
    unpaired.value = true;
    daemons.value = null;
    await look();
}

export function keepInformed(): void {
    void look();
    setInterval(() => void look(), LOOK_MS);
    setInterval(tellAge, TICK_MS);
    document.addEventListener('visibilitychange', () => void look());
}
