// The text that is being edited, one for each daemon. It outlives a change of the screen and a
// reload of the page.
import { computed, signal } from '@preact/signals';
import { getText } from './api';
import { daemonName } from './store';

export interface Draft {
    /** The file as it was when the editing began, and its ETag. */
    base: string;
    tag: string;
    text: string;
}

const drafts = signal<Record<string, Draft>>(saved());

function saved(): Record<string, Draft> {
    try {
        return JSON.parse(sessionStorage.getItem('drafts') ?? '{}') as Record<string, Draft>;
    } catch {
        return {};
    }
}

export const draft = computed<Draft | undefined>(() => drafts.value[daemonName.value]);
export const changed = computed(() =>
    draft.value !== undefined && draft.value.text !== draft.value.base);

export function setDraft(name: string, next: Draft): void {
    drafts.value = { ...drafts.value, [name]: next };
    try {
        sessionStorage.setItem('drafts', JSON.stringify(drafts.value));
    } catch {
        // A browser that keeps nothing loses the draft with the page.
    }
}

export function setText(text: string): void {
    const now = draft.value;
    if (now && now.text !== text) {
        setDraft(daemonName.value, { ...now, text });
    }
}

export async function fileOnDisk(name: string): Promise<Draft> {
    const { text, tag } = await getText(`/api/${encodeURIComponent(name)}/configuration`);
    return { base: text, tag, text };
}

/** Takes the file as it stands; an unchanged draft is replaced, a changed one stays. */
export async function openDraft(name: string): Promise<void> {
    const before = drafts.value[name];
    const file = await fileOnDisk(name);
    const now = drafts.value[name];
    // What was kept while the file was under way is newer than the file.
    if (now === before && (!now || now.text === now.base)) {
        setDraft(name, file);
    }
}

/** Puts lines at the end of a table of the draft; a new table is made if there is none. */
export function withLines(text: string, table: string, lines: string[]): string {
    const all = text.split('\n');
    const start = all.findIndex((line) => line.trim() === `[${table}]`);
    if (start < 0) {
        return `${text.trimEnd()}\n\n[${table}]\n${lines.join('\n')}\n`;
    }
    let end = all.findIndex((line, i) => i > start && line.trim().startsWith('['));
    end = end < 0 ? all.length : end;
    while (end > start + 1 && all[end - 1]!.trim() === '') {
        end -= 1;
    }
    all.splice(end, 0, ...lines);
    return all.join('\n');
}
