// A real board for tests: the built programs, and a simulated receiver and servos on ptys.
import { execFile, spawn } from 'node:child_process';
import { mkdtemp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const here = dirname(fileURLToPath(import.meta.url));
const PROGRAMS = process.env.TRIBUS_PROGRAMS ?? resolve(here, '../../../../build/app');
const PATIENCE_MS = 15_000;

/** Calls `look` until it returns something. */
export async function until(look, what, patience = PATIENCE_MS) {
    const end = performance.now() + patience;
    for (;;) {
        const found = await look();
        if (found) {
            return found;
        }
        if (performance.now() > end) {
            throw new Error(`never came: ${what()}`);
        }
        await new Promise((later) => { setTimeout(later, 10); });
    }
}

/** Keeps what a process says. */
class Listener {
    text = '';
    ended = false;

    constructor(child, stream) {
        stream.on('data', (bytes) => { this.text += bytes; });
        child.on('close', () => { this.ended = true; });
    }
    /** Waits for a line, from the place `from` on, and returns the match. */
    says(pattern, { from = 0, patience = PATIENCE_MS } = {}) {
        return until(() => pattern.exec(this.text.slice(from)),
            () => `${pattern} in ${this.text.slice(from)}`, patience);
    }
}

/** "13:04:05.678" of the last 24 hours, as the log has it, in ms of the wall clock. */
function wallTime(text) {
    const [hours, minutes, seconds] = text.split(':').map(Number);
    const time = new Date().setHours(hours, minutes, 0, Math.round(seconds * 1000));
    const ahead = time > Date.now() + 60_000;
    return ahead ? time - 24 * 3_600_000 : time;
}

async function startReceiver() {
    const child = spawn('python3', [join(here, 'receiver.py')],
        { stdio: ['pipe', 'pipe', 'inherit'] });
    const said = new Listener(child, child.stdout);
    const [, receiver, servos] = await said.says(/(\S+) (\S+)\n/);
    const command = (line) => child.stdin.write(`${line}\n`);
    return { child, said, receiver, servos, command };
}

const mainJob = (wires, more) => `[input.receiver]
protocol = "ibus"
device = "${wires.receiver}"

[output.servos]
protocol = "sbus"
device = "${wires.servos}"

[pipeline.main]
from = "receiver"
to = "servos"
${more}`;

/**
 * `map`: further text of the configuration. `runs`: whether a daemon runs it. `text`: another
 * configuration, made from the paths of the ptys. `page`: another folder of the page. `words`: more
 * options of the server.
 */
export async function startBoard(options = {}) {
    const folder = await mkdtemp(join(tmpdir(), 'tribus-board-'));
    const [runtime, state] = [join(folder, 'run'), join(folder, 'state')];
    const file = join(folder, 'boat.toml');
    await mkdir(runtime);
    await mkdir(state);
    const wires = await startReceiver();
    await writeFile(file, options.text?.(wires) ?? mainJob(wires, options.map ?? ''));
    const children = new Set([wires.child]);
    const environment = { ...process.env, XDG_RUNTIME_DIR: runtime, RUNTIME_DIRECTORY: '' };
    const start = (program, ...words) => {
        const child = spawn(join(PROGRAMS, program), words, {
            env: environment, stdio: ['ignore', 'ignore', 'pipe'],
        });
        children.add(child);
        return { child, log: new Listener(child, child.stderr) };
    };
    const socket = join(runtime, 'tribus', 'boat.sock');
    const run = async (...words) => (await promisify(execFile)(join(PROGRAMS, 'tribus'), words,
        { env: environment })).stdout;
    const serve = async (port) => {
        const server = start('tribus-web', 'serve', '--listen', `127.0.0.1:${port}`,
            '--configurations', folder, '--state', state, '--page',
            options.page ?? resolve(here, '../dist'), ...(options.words ?? []));
        const [, address] = await server.log.says(/the page is at (\S+)/);
        return { server: server.child, address };
    };
    const { server, address } = await serve(0);
    const board = {
        address, file, state, port: Number(new URL(address).port), server,
        daemon: null, log: null,
        async stopDaemon() {
            board.daemon?.kill('SIGKILL');
            await until(() => board.log?.ended ?? true, () => 'the end of the daemon');
        },
        /** Starts the server, which was killed, at the same address. */
        async runServer() {
            board.server = (await serve(board.port)).server;
        },
        /** Starts the daemon, again if it runs. */
        async runDaemon() {
            await board.stopDaemon();
            const { child, log } = start('tribus', 'run', file, '--socket', socket);
            [board.daemon, board.log] = [child, log];
        },
        setPulses: (pulses) => wires.command(`pulses ${pulses.join(' ')}`),
        sweep: () => wires.command('sweep'),
        cutWire: (cut) => wires.command(cut ? 'cut' : 'mend'),
        /** Waits until the servos got this last: "control 1100 1500 1500 1500". */
        servos: (words, patience) => until(() => wires.said.text.endsWith(`${words}\n`),
            () => `${words} at the servos, whose last is ${wires.said.text.slice(-60)}`, patience),
        text: () => readFile(file, 'utf8'),
        write: (text) => writeFile(file, text),
        reload: () => run('reload', '--socket', socket),
        /** When the daemon wrote such a line into its log, in ms of the wall clock. */
        async logged(line, from = 0) {
            const found = await board.log.says(
                new RegExp(`(\\d[\\d:.]+) \\w+ .*${line.source}`), { from });
            return wallTime(found[1]);
        },
        async code(...words) {
            return (await run('pair', '--state', state, ...words)).split('\n')[0];
        },
        pairing: (...words) => run('pair', '--state', state, ...words),
        async close() {
            for (const child of children) {
                child.kill('SIGKILL');
            }
            await rm(folder, { recursive: true, force: true });
        },
    };
    if (options.runs ?? true) {
        await board.runDaemon();
    }
    return board;
}
