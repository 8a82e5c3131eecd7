// Requests to the server. Every failure is an ApiError with a sentence for the user.
import { signal } from '@preact/signals';

export class ApiError extends Error {
    constructor(readonly status: number, text: string,
                readonly body: Record<string, unknown> = {}) {
        super(text);
    }
}

/** Set by the first 401: the page shows how to pair. */
export const unpaired = signal(false);

const ANSWER_LIMIT_MS = 15_000;

async function failure(response: Response): Promise<ApiError> {
    let body: Record<string, unknown> = {};
    try {
        body = await response.json();
    } catch {
        // A proxy between may answer with anything.
    }
    const text = typeof body.error === 'string' ? body.error
        : `The server answers ${response.status}.`;
    if (response.status === 401) {
        unpaired.value = true;
    }
    return new ApiError(response.status, text, body);
}

async function send(path: string, init: RequestInit, limit = ANSWER_LIMIT_MS): Promise<Response> {
    let response: Response;
    try {
        response = await fetch(path, {
            ...init, cache: 'no-store', signal: AbortSignal.timeout(limit),
        });
    } catch (error) {
        const late = error instanceof DOMException && error.name === 'TimeoutError';
        throw new ApiError(0, late
            ? `The board did not answer for ${limit / 1000} s.`
            : 'The board cannot be reached.');
    }
    if (!response.ok) {
        throw await failure(response);
    }
    return response;
}

async function json<T>(response: Response): Promise<T> {
    try {
        return await response.json() as T;
    } catch {
        throw new ApiError(0, 'The answer of the board is incomplete.');
    }
}

export async function get<T>(path: string, limit?: number): Promise<T> {
    return json<T>(await send(path, {}, limit));
}

export async function getText(path: string): Promise<{ text: string; tag: string }> {
    const response = await send(path, {});
    return { text: await response.text(), tag: response.headers.get('ETag') ?? '' };
}

interface PostOptions {
    match?: string;
    limit?: number;
}

function posted(path: string, body: object, options: PostOptions): Promise<Response> {
    const headers: Record<string, string> = {
        'Content-Type': 'application/json', 'X-Tribus': '1',
    };
    if (options.match) {
        headers['If-Match'] = options.match;
    }
    return send(path, { method: 'POST', headers, body: JSON.stringify(body) }, options.limit);
}

export async function post<T>(path: string, body: object, options: PostOptions = {}): Promise<T> {
    return json<T>(await posted(path, body, options));
}

export async function postForText(path: string, body: object): Promise<string> {
    return (await posted(path, body, {})).text();
}

export const errorText = (error: unknown): string =>
    error instanceof Error ? error.message : String(error);
export const statusOf = (error: unknown): number =>
    error instanceof ApiError ? error.status : -1;
