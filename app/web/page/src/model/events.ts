// Reads server-sent events with fetch: an EventSource does not tell 401 from a dead network.

export interface ServerEvent {
    name: string;
    data: string;
}

/** More without an empty line is no event. */
const LONGEST_EVENT = 1 << 20;

/** Splits the text of a stream into events; the rest of an unfinished event stays. */
export class EventParser {
    private rest = '';

    take(text: string): ServerEvent[] {
        this.rest = (this.rest + text).replaceAll('\r\n', '\n');
        const parts = this.rest.split('\n\n');
        this.rest = parts.pop() ?? '';
        if (this.rest.length > LONGEST_EVENT) {
            throw new Error('an event is too long');
        }
        return parts.map(parseEvent).filter((event) => event.data !== '');
    }
}

function parseEvent(text: string): ServerEvent {
    let name = 'message';
    const data: string[] = [];
    for (const line of text.split('\n')) {
        const [, field, value] = /^([a-z]+): ?(.*)$/.exec(line) ?? [];
        if (field === 'event') {
            name = value ?? '';
        } else if (field === 'data') {
            data.push(value ?? '');
        }
    }
    return { name, data: data.join('\n') };
}

export interface StreamHandlers {
    /** All events that arrived together, oldest first. */
    events(events: ServerEvent[]): void;
    /** The stream ended: `status` is that of the answer, 0 if there was none. */
    end(status: number, text: string): void;
}

/** Returns a function that closes the stream; no handler is called after it. */
export function openStream(path: string, handlers: StreamHandlers): () => void {
    const abort = new AbortController();
    const end = (status: number, text: string) => {
        if (!abort.signal.aborted) {
            handlers.end(status, text);
        }
    };
    void readStream(path, abort, handlers).then(
        ([status, text]) => end(status, text), () => end(0, ''));
    return () => abort.abort();
}

async function readStream(path: string, abort: AbortController,
                          handlers: StreamHandlers): Promise<[number, string]> {
    const response = await fetch(path, {
        headers: { Accept: 'text/event-stream' }, cache: 'no-store', signal: abort.signal,
    });
    if (!response.ok || !response.body) {
        const body = await response.json().catch(() => ({})) as { error?: string };
        return [response.status, body.error ?? ''];
    }
    const reader = response.body.getReader();
    const decoder = new TextDecoder();
    const parser = new EventParser();
    for (;;) {
        const { done, value } = await reader.read();
        if (done || abort.signal.aborted) {
            return [response.status, ''];
        }
        const events = parser.take(decoder.decode(value, { stream: true }));
        if (events.length > 0) {
            handlers.events(events);
        }
    }
}
