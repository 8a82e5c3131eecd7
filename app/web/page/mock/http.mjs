// The parts of HTTP that every answer of the mock has.
export const CSP = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    + "img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'self'";

export class Refusal extends Error {
    constructor(status, text, more = {}) {
        super(text);
        this.status = status;
        this.body = { error: text, ...more };
    }
}

const COMMON = {
    'Content-Security-Policy': CSP,
    'X-Content-Type-Options': 'nosniff',
    'Referrer-Policy': 'no-referrer',
    'Cache-Control': 'no-store',
};

export function answer(response, status, type, body, headers = {}) {
    response.writeHead(status, { ...COMMON, 'Content-Type': type, ...headers });
    response.end(body);
}

export function answerJson(response, body, status = 200) {
    answer(response, status, 'application/json', JSON.stringify(body));
}

export async function readJson(request) {
    if (request.headers['content-type'] !== 'application/json' || !request.headers['x-tribus']) {
        throw new Refusal(403, 'A change needs JSON and the header X-Tribus.');
    }
    if (!request.headers.origin?.endsWith(`//${request.headers.host}`)) {
        throw new Refusal(403, 'A change must come from this page.');
    }
    let text = '';
    for await (const part of request) {
        text += part;
    }
    return JSON.parse(text);
}

export function beginStream(response) {
    response.writeHead(200, { ...COMMON, 'Content-Type': 'text/event-stream' });
    response.flushHeaders();
}

export function sendEvent(response, name, data) {
    response.write(`event: ${name}\ndata: ${JSON.stringify(data)}\n\n`);
}
