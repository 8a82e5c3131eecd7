// A real board for tests: the built programs, a simulated receiver and servos on UDP.
import { execFile, spawn } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { mkdtemp, mkdir, readFile, rm, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { promisify } from 'node:util';

const here = dirname(fileURLToPath(import.meta.url));
const PROGRAMS = process.env.TRIBUS_PROGRAMS ?? resolve(here, '../../../../build/app');
const FRAME_MS = 7;

/** A frame of i.Bus (docs/protocols/ibus.md, "Servo frame"), written out. */
function ibusFrame(pulses) {
    const bytes = [0x20, 0x40];
    for (let channel = 0; channel < 14; ++channel) {
        const us = pulses[channel] ?? 1500;
        bytes.push(us % 256, Math.floor(us / 256));
    }
    const sum = 0xffff - bytes.reduce((total, byte) => total + byte, 0);
    return Buffer.from([...bytes, sum % 256, Math.floor(sum / 256)]);
}

const port = (socket) => new Promise((ready) => {
    socket.bind(0, '127.0.0.1', () => ready(socket.address().port));
});

function said(child, text) {
    return new Promise((ready, failed) => {
        let all = '';
        child.on('exit', (code) => failed(new Error(`ended with ${code}: ${all}`)));
        child.stderr.on('data', (bytes) => {
            all += bytes;
            const at = all.indexOf(text);
            if (at >= 0) {
                ready(all.slice(at + text.length).split(/\s/)[0]);
            }
        });
    });
}

export async function startBoard({ map = '' } = {}) {
    const folder = await mkdtemp(join(tmpdir(), 'tribus-board-'));
    const runtime = join(folder, 'run');
    const state = join(folder, 'state');
    const file = join(folder, 'boat.toml');
    await mkdir(runtime);
    await mkdir(state);
    const free = createSocket('udp4');
    const receiverPort = await port(free);
    await new Promise((closed) => { free.close(closed); });
    const servos = createSocket('udp4');
    const servoPort = await port(servos);
    const text = `[input.receiver]
protocol = "ibus"
address = "127.0.0.1:${receiverPort}"

[output.servos]
protocol = "sbus"
address = "127.0.0.1:${servoPort}"

[pipeline.main]
from = "receiver"
to = "servos"
${map}`;
    await writeFile(file, text);
    const environment = { ...process.env, XDG_RUNTIME_DIR: runtime, RUNTIME_DIRECTORY: '' };
    const start = (program, ...words) => spawn(join(PROGRAMS, program), words, {
        env: environment, stdio: ['ignore', 'ignore', 'pipe'],
    });
    const socket = join(runtime, 'tribus', 'boat.sock');
    const log = { text: '', at: new Map() };
    const runDaemon = async () => {
        const child = start('tribus', 'run', file, '--socket', socket);
        child.stderr.on('data', (bytes) => {
            log.text += bytes;
            for (const line of String(bytes).split('\n')) {
                log.at.set(line.replace(/^\S+ \w+ /, ''), performance.now());
            }
        });
        return child;
    };
    const daemon = await runDaemon();
    const server = start('tribus-web', 'serve', '--listen', '127.0.0.1:0', '--configurations',
        folder, '--state', state, '--page', resolve(here, '../dist'));
    const address = await said(server, 'the page is at ');
    const sender = createSocket('udp4');
    let pulses = [1100];
    let sends = true;
    const timer = setInterval(() => {
        if (sends) {
            sender.send(ibusFrame(pulses), receiverPort, '127.0.0.1');
        }
    }, FRAME_MS);
    return {
        address, daemon, server, file, log,
        setPulses(next) { pulses = next; },
        cutWire(cut) { sends = !cut; },
        text: () => readFile(file, 'utf8'),
        /** When the daemon logged such a line. */
        async logged(line) {
            for (let tries = 0; tries < 500; ++tries) {
                const found = [...log.at].find(([text]) => line.test(text));
                if (found) {
                    return found[1];
                }
                await new Promise((later) => { setTimeout(later, 10); });
            }
            throw new Error(`the daemon never logged ${line}: ${log.text}`);
        },
        async code(...words) {
            const { stdout } = await promisify(execFile)(join(PROGRAMS, 'tribus'),
                ['pair', '--state', state, ...words]);
            return stdout.split('\n')[0];
        },
        async close() {
            clearInterval(timer);
            for (const child of [daemon, server]) {
                child.removeAllListeners('exit');
                child.kill('SIGKILL');
            }
            sender.close();
            servos.close();
            await rm(folder, { recursive: true, force: true });
        },
    };
}
