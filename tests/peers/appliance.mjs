// The program with a configuration, and what stands at the ends of its ports.
import { spawn, spawnSync } from 'node:child_process';
import { createSocket } from 'node:dgram';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const PROGRAM = join(process.env.TRIBUS_PROGRAMS ?? '../../build/app', 'tribus');

export const sleep = milliseconds => new Promise(done => setTimeout(done, milliseconds));

// An i.Bus frame of 14 channels, by the layout of docs/protocols/ibus.md.
export function ibusFrame(channels) {
    const frame = Buffer.alloc(32);
    frame.writeUInt16LE(0x4020, 0);
    for (let i = 0; i < 14; ++i) {
        frame.writeUInt16LE(channels[i] ?? 1500, 2 + 2 * i);
    }
    let sum = 0xffff;
    for (const byte of frame.subarray(0, 30)) {
        sum -= byte;
    }
    frame.writeUInt16LE(sum & 0xffff, 30);
    return frame;
}

// The channels of an i.Bus frame.
export const ibusChannels = frame =>
    Array.from({ length: 14 }, (_, i) => frame.readUInt16LE(2 + 2 * i) & 0x0fff);

// A UDP socket that keeps what arrives.
export async function receiver() {
    const socket = createSocket('udp4');
    await new Promise(done => socket.bind(0, '127.0.0.1', done));
    socket.unref();
    const datagrams = [];
    socket.on('message', datagram => datagrams.push(datagram));
    return { socket, datagrams, address: `127.0.0.1:${socket.address().port}` };
}

// An address at which nobody receives yet.
export async function freeAddress() {
    const { socket, address } = await receiver();
    await new Promise(done => socket.close(done));
    return address;
}

export function sendTo(socket, address, bytes) {
    const [host, port] = address.split(':');
    socket.send(bytes, Number(port), host);
}

// Runs the program with this configuration while `work` runs. Returns its log.
export async function withAppliance(configuration, work) {
    const folder = mkdtempSync(join(tmpdir(), 'tribus-peers-'));
    const file = join(folder, 'peer.toml');
    writeFileSync(file, configuration);
    const daemon = spawn(PROGRAM, ['run', file, '--socket', join(folder, 'socket')],
        { stdio: ['ignore', 'ignore', 'pipe'] });
    let log = '';
    daemon.stderr.on('data', text => { log += text; });
    const ended = new Promise(done => daemon.on('exit', done));
    try {
        await sleep(500);
        await work();
    } catch (error) {
        error.message += `\nlog of the program:\n${log}`;
        throw error;
    } finally {
        daemon.kill('SIGTERM');
        await ended;
        rmSync(folder, { recursive: true });
    }
    return log;
}

// What `tribus decode` makes of these bytes, an object a line.
export function decode(bytes, ...options) {
    const ran = spawnSync(PROGRAM, ['decode', '--format', 'json', ...options, '-'], { input: bytes });
    if (ran.status !== 0) {
        throw new Error(`decode: ${ran.stderr}`);
    }
    return String(ran.stdout).trim().split('\n').map(line => JSON.parse(line));
}
