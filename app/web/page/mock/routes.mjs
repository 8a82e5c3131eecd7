// Answers of the mock, as docs/web.md describes them.
import { mistakesOf } from './board.mjs';
import { answer, answerJson, beginStream, readJson, Refusal, sendEvent } from './http.mjs';

const SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="420" height="90" viewBox="0 0 420 90">'
    + '<rect width="100%" height="100%" fill="#fff"/><g fill="none" stroke="#444">'
    + '<rect x="10" y="20" width="150" height="50"/><rect x="250" y="20" width="150" height="50"/>'
    + '<path d="M160 45H250"/></g><g font-family="monospace" font-size="13">'
    + '<text x="24" y="50">receiver</text><text x="264" y="50">servos</text></g></svg>';

const GET = {
    status: (board, name, _, response) => answerJson(response, board.status(name)),
    stream,
    changes(board, name, rest, response) {
        const list = board.changes[name]?.list ?? [];
        answerJson(response, { type: 'changes', newest: list.length, lost: 0,
            changes: list.filter((one) => one.number > Number(rest)) });
    },
    configuration(board, name, _, response) {
        answer(response, 200, 'text/plain', board.fileOf(name).text,
            { ETag: `"${board.tagOf(name)}"` });
    },
    schema: (board, name, _, response) => answerJson(response, board.schema),
    'graph.svg': (board, name, _, response) => answer(response, 200, 'image/svg+xml', SVG),
    history(board, name, rest, response) {
        const { history } = board.fileOf(name);
        if (rest) {
            answer(response, 200, 'text/plain', history.find((one) => one.id === rest).text);
        } else {
            answerJson(response, { files: history.map(({ text, ...file }) => file) });
        }
    },
    record(board, name, rest, response) {
        answerJson(response, board.records[Number(rest) - 1]
            ?? { number: Number(rest), state: 'failed', reason: 'no such recording' });
    },
    recordings,
    histograms: (board, name, _, response) => answerJson(response, histograms(board.status(name))),
};

/// Starts of the buckets as the daemon has them (pipelines/realtime/histogram.h).
const STARTS_US = Array.from({ length: 80 }, (_, bucket) => 0.256 * (bucket < 4 ? bucket
    : (bucket % 4 + 4) * 2 ** (Math.floor(bucket / 4) - 1)));

function histograms(status) {
    const reading = (middle, all) => ({
        counts: Array.from({ length: middle + 9 }, (_, bucket) =>
            Math.round(all * Math.exp(-((bucket - middle) ** 2) / 4))),
        max_us: STARTS_US[middle + 3] });
    const both = (middle) => ({
        last_minute: reading(middle, 4000), since_start: reading(middle, 400_000) });
    return { type: 'histograms', version: 1, t_us: 1, starts_us: STARTS_US, inputs: [],
        outputs: status.outputs.map(({ name }) =>
            ({ name, lateness: both(24), latency: both(48) })) };
}

function stream(board, name, _, response) {
    beginStream(response);
    const daemon = board.daemons.find((one) => one.name === name);
    const send = () => {
        if (!board.sends) {
            return;
        }
        if (!board.paired) {
            sendEvent(response, 'revoked', {});
            response.end();
        } else if (board.gone || daemon.state === 'absent') {
            sendEvent(response, 'gone', { reason: board.gone ?? 'no daemon runs' });
        } else {
            sendEvent(response, 'status', board.status(name));
        }
    };
    const timer = setInterval(send, 100);
    board.streams.add(response);
    response.on('close', () => {
        clearInterval(timer);
        board.streams.delete(response);
    });
    send();
}

function recordings(board, name, rest, response, query) {
    if (board.busyPlots > 0 && rest?.endsWith('/plot')) {
        board.busyPlots--;
        throw new Refusal(503, 'Another recording is being read.');
    }
    if (!rest) {
        answerJson(response, board.recorder
            ? { directory: `/var/lib/tribus/${name}`, recordings: board.recordings }
            : { directory: null, recordings: [] });
    } else if (rest.endsWith('.tar')) {
        answer(response, 200, 'application/x-tar', Buffer.alloc(1024),
            { 'Content-Disposition': 'attachment' });
    } else {
        answerJson(response, plot(Number(query.get('from') ?? 0), Number(query.get('to') ?? 6e6),
            Number(query.get('width') ?? 800)));
    }
}

function plot(from, to, width) {
    const end = Math.min(to, 32_000_000);
    const at = (i) => from + (end - from) * i / width;
    const series = ['receiver', 'servos'].flatMap((name) => [1, 2, 3].map((channel) => {
        const middle = Array.from({ length: width }, (_, i) => at(i) > 25e6 && name === 'receiver'
            ? null : Math.round(1500 + 400 * Math.sin(at(i) / 3e6 + channel)));
        return { name, channel, kind: name === 'servos' ? 'output' : 'input',
            least: middle.map((us) => us === null ? null : us - 4),
            greatest: middle.map((us) => us === null ? null : us + 4) };
    }));
    const states = [['unknown', 0, 0.6e6], ['control', 0.6e6, 25.1e6], ['hold', 25.1e6, 25.4e6], ['failsafe', 25.4e6, 32e6]]
        .map(([state, start, stop]) => ({ output: 'servos', from_us: start, to_us: stop, state }));
    return { from_us: from, to_us: end, length_us: 32_000_000, problem: null, states_left_out: 0,
        states, series };
}

const POST = {
    check: (board, name, body) => ({ mistakes: mistakesOf(body.toml) }),
    diff(board, name, body) {
        const same = body.toml === board.fileOf(name).text;
        return { same, mistakes: mistakesOf(body.toml), lines: same ? [] : [
            'pipeline main:', '  failsafe.hold: 300ms before, now 200ms',
            '  channel 2: channel 2 before, now channel 2, reverse',
            '  (applies from the next frame of its outputs)'],
        outputs: same ? [] : [{ output: 'servos',
            channels: [{ channel: 2, now_us: 1300, then_us: 1700 }] }] };
    },
    draft(board, name, body, request) {
        const tag = board.tagOf(name);
        if (request.headers['if-match'] !== `"${tag}"`) {
            throw new Refusal(412, 'The file was changed by another meanwhile.',
                { fingerprint: tag });
        }
        const mistakes = mistakesOf(body.toml);
        if (mistakes.length > 0) {
            return { taken: false, lines: mistakes.map((one) =>
                `${one.line}:${one.column}: ${one.text}`) };
        }
        return { taken: true, lines: [], trial: board.startTrial(name, body.toml, body.seconds) };
    },
    confirm(board, name, body) {
        const trial = board.endTrial(name, body.trial);
        board.changeByAnother(name, trial.toml);
        return { kept: true, fingerprint: board.tagOf(name) };
    },
    back(board, name, body) {
        board.endTrial(name, body.trial);
        return { lines: ['went back to the configuration before'] };
    },
    save(board, name, body, request) {
        if (request.headers['if-match'] !== `"${board.tagOf(name)}"`) {
            throw new Refusal(412, 'The file was changed by another meanwhile.');
        }
        board.changeByAnother(name, body.toml);
        return { fingerprint: board.tagOf(name) };
    },
    record(board) {
        if (!board.recorder) {
            throw new Refusal(409, 'This configuration has no [recorder].');
        }
        const record = { number: board.records.length + 1, state: 'writing' };
        board.records.push(record);
        setTimeout(() => {
            record.state = 'written';
            record.folder = '/var/lib/tribus/boat/2026-11-26T04-30-00Z-request';
        }, 800);
        return record;
    },
};

const needsChange = new Set(['draft', 'confirm', 'back', 'save', 'record']);

export async function daemonRoute(board, request, response, name, verb, rest, query) {
    if (!board.daemons.some((one) => one.name === name)) {
        throw new Refusal(404, 'There is no such daemon.');
    }
    if (request.method === 'GET' && GET[verb]) {
        GET[verb](board, name, rest, response, query);
        return;
    }
    if (request.method !== 'POST') {
        throw new Refusal(404, 'There is nothing here.');
    }
    const body = await readJson(request);
    if (verb === 'graph') {
        answer(response, 200, 'image/svg+xml', SVG);
        return;
    }
    if (!POST[verb]) {
        throw new Refusal(404, 'There is nothing here.');
    }
    if (needsChange.has(verb) && board.role !== 'change') {
        throw new Refusal(403, 'This browser may only look.');
    }
    answerJson(response, POST[verb](board, name, body, request));
}
