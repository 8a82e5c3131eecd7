// A server with the answers of tribus-web and a simulated board behind it, for developing:
//   node mock.mjs [--port 8480] [--scene failsafe] [--unpaired] [--look] [--schema FILE]
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { basename, dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { Board } from './mock/board.mjs';
import { answer, answerJson, readJson, Refusal } from './mock/http.mjs';
import { daemonRoute } from './mock/routes.mjs';
import { doctorReport, learn } from './mock/tools.mjs';

const DIST = join(dirname(fileURLToPath(import.meta.url)), 'dist');
const TYPES = { js: 'text/javascript', css: 'text/css' };

async function asset(board, response, name) {
    if (board.brokenAsset?.test(name)) {
        throw new Refusal(404, 'There is nothing here.');
    }
    const body = await readFile(join(DIST, 'assets', basename(name)));
    answer(response, 200, TYPES[name.split('.').pop()], body,
        { 'Cache-Control': 'public, max-age=31536000, immutable' });
}

async function pair(board, request, response) {
    const { code } = await readJson(request);
    if (board.code === null) {
        throw new Refusal(410, 'No code is valid now.');
    }
    if (code !== board.code) {
        throw new Refusal(403, 'The code is wrong.', { wait_s: 2 });
    }
    board.paired = true;
    answerJson(response, { role: board.role });
}

async function api(board, request, response, parts, query) {
    const [first, second, ...rest] = parts;
    if (first === 'me') {
        answerJson(response, { role: board.paired ? board.role : null, host: 'boat',
            public: board.public, version: '0.2.0' });
        return;
    }
    if (!board.paired) {
        throw new Refusal(401, 'This browser is not paired.');
    }
    if (first === 'daemons') {
        answerJson(response, { daemons: board.daemons });
    } else if (first === 'doctor') {
        answerJson(response, doctorReport((await readJson(request)).device));
    } else if (first === 'learn') {
        await readJson(request);
        answerJson(response, learn(board, second));
    } else {
        await daemonRoute(board, request, response, first, second, rest[0], query);
    }
}

async function route(board, request, response) {
    const address = new URL(request.url, 'http://board');
    const parts = address.pathname.split('/').filter(Boolean).map(decodeURIComponent);
    board.requests.push(`${request.method} ${address.pathname}`);
    if (board.dead && parts[0] === 'api') {
        return; // The server accepts and stays silent.
    }
    if (parts.length === 0) {
        answer(response, 200, 'text/html; charset=utf-8', await readFile(join(DIST, 'index.html')));
    } else if (parts[0] === 'assets') {
        await asset(board, response, parts[1]);
    } else if (parts[0] === 'api') {
        await api(board, request, response, parts.slice(1), address.searchParams);
    } else if (parts[0] === 'pair') {
        await pair(board, request, response);
    } else if (parts[0] === 'leave') {
        board.paired = false;
        answerJson(response, {});
    } else {
        throw new Refusal(404, 'There is nothing here.');
    }
}

export async function startMock({ port = 0, schema } = {}) {
    const board = new Board(schema);
    const server = createServer((request, response) => {
        route(board, request, response).catch((error) => {
            const refusal = error instanceof Refusal ? error : new Refusal(500, String(error));
            answerJson(response, refusal.body, refusal.status);
        });
    });
    await new Promise((done) => { server.listen(port, '127.0.0.1', done); });
    return {
        board,
        address: `http://127.0.0.1:${server.address().port}/`,
        close() {
            server.closeAllConnections();
            server.close();
        },
    };
}

function option(name) {
    const at = process.argv.indexOf(`--${name}`);
    return at < 0 ? undefined : process.argv[at + 1] ?? true;
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
    const port = Number(option('port') ?? 8480);
    const mock = await startMock({ port, schema: option('schema') });
    mock.board.paired = option('unpaired') === undefined;
    mock.board.role = option('look') === undefined ? 'change' : 'look';
    mock.board.scenes.boat = option('scene') ?? 'good';
    console.log(`${mock.address}  (pairing code ${mock.board.code})`);
}
