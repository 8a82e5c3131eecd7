// MAVLink against node-mavlink, which was made from MAVLink's own XML files.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { PassThrough } from 'node:stream';
import { test } from 'node:test';
import nodeMavlink from 'node-mavlink';
import { decode, freeAddress, ibusChannels, ibusFrame, receiver, sendTo, sleep, withAppliance } from './appliance.mjs';

const { MavLinkPacketParser, MavLinkPacketSignature, MavLinkPacketSplitter, MavLinkProtocolV1, MavLinkProtocolV2, common, development,
    minimal } = nodeMavlink;
const REGISTRY = { ...minimal.REGISTRY, ...common.REGISTRY, ...development.REGISTRY };

// The messages in these datagrams, as node-mavlink reads them. It drops those whose CRC is wrong.
async function messagesIn(datagrams) {
    const stream = new PassThrough();
    const messages = [];
    const parser = stream.pipe(new MavLinkPacketSplitter()).pipe(new MavLinkPacketParser());
    parser.on('data', packet => {
        const kind = REGISTRY[packet.header.msgid];
        messages.push({
            kind: kind.MSG_NAME, signature: packet.signature, system: packet.header.sysid, component: packet.header.compid,
            sequence: packet.header.seq, version: packet.protocol instanceof MavLinkProtocolV1 ? 1 : 2,
            fields: packet.protocol.data(packet.payload, kind),
        });
    });
    stream.end(Buffer.concat(datagrams));
    await new Promise(done => parser.on('end', done));
    return messages;
}

// Steers an output of MAVLink with i.Bus frames for a second. Returns what it sent.
async function sentWith(lines, channels, seconds = 1.5) {
    const autopilot = await receiver();
    const input = await freeAddress();
    await withAppliance(`
[input.receiver]
protocol = "ibus"
address  = "${input}"
[output.drone]
protocol = "mavlink"
address  = "${autopilot.address}"
${lines}
[pipeline.main]
from = "receiver"
to   = "drone"
`, async () => {
        for (let i = 0; i < seconds * 100; ++i) {
            sendTo(autopilot.socket, input, ibusFrame(channels));
            await sleep(10);
        }
        autopilot.ended = autopilot.datagrams.length;
        await sleep(700);
    });
    autopilot.socket.close();
    return autopilot;
}

const STICKS = [1000, 1234, 2000, 1500, 1501, 1999, 1100, 1900, 1200, 1800, 1300, 1700, 1400, 1600];

test('what tribus sends as RADIO_RC_CHANNELS is read with the channels, and a heartbeat each second', async () => {
    const { datagrams, ended } = await sentWith('system = 51\ncomponent = 68\nchannels = 14', STICKS);
    const messages = await messagesIn(datagrams.slice(0, ended));
    // Until the input counts as good, the frames are marked failsafe.
    const radio = messages.filter(({ kind, fields }) => kind === 'RADIO_RC_CHANNELS' && fields.flags === 0);
    const heartbeats = messages.filter(message => message.kind === 'HEARTBEAT');
    assert.ok(radio.length > 40, `${radio.length} messages`);
    const seconds = (radio.at(-1).fields.timeLastUpdateMs - radio[0].fields.timeLastUpdateMs) / 1000;
    assert.ok(Math.abs(heartbeats.length - seconds - 1) <= 1, `${heartbeats.length} heartbeats in ${seconds} s`);
    assert.equal(heartbeats[0].fields.type, minimal.MavType.GCS);
    assert.equal(heartbeats[0].fields.autopilot, minimal.MavAutopilot.INVALID);
    for (const { fields, system, component } of radio) {
        assert.equal(system, 51);
        assert.equal(component, 68);
        assert.equal(fields.targetSystem, 1);
        assert.equal(fields.count, 14);
        STICKS.forEach((pulse, i) => assert.ok(Math.abs(fields.channels[i] * 5 / 32 + 1500 - pulse) < 0.1));
    }
    messages.forEach((message, i) => assert.equal(message.sequence, (messages[0].sequence + i) % 256));
});

for (const version of [1, 2]) {
    test(`what tribus sends as RC_CHANNELS_OVERRIDE of version ${version} is read`, async () => {
        const { datagrams } = await sentWith(
            `message = "rc_channels_override"\nversion = ${version}\nchannels = 8\ntarget = 7`, STICKS);
        const overrides = (await messagesIn(datagrams)).filter(message => message.kind === 'RC_CHANNELS_OVERRIDE');
        assert.ok(overrides.length > 40, `${overrides.length} messages`);
        for (const { fields, version: sent, system } of overrides) {
            assert.equal(sent, version);
            assert.equal(system, 255);
            assert.equal(fields.targetSystem, 7);
            assert.deepEqual([1, 2, 3, 4, 5, 6, 7, 8].map(i => fields[`chan${i}Raw`]), STICKS.slice(0, 8));
        }
    });
}

test('on loss overrides and heartbeats stop within the timeout and the period', async () => {
    const { datagrams, ended } = await sentWith('message = "rc_channels_override"\nchannels = 14', STICKS);
    // After 100 ms the input counts as lost, for 300 ms more its values are held; every 20 ms one frame.
    const after = datagrams.length - ended;
    assert.ok(after <= 25, `${after} datagrams after the loss, 35 in the time that was looked at`);
});

test('with on_loss = "release" the channels are given back', async () => {
    const { datagrams, ended } = await sentWith(
        'message = "rc_channels_override"\nchannels = 14\non_loss = "release"', STICKS);
    const after = await messagesIn(datagrams.slice(ended));
    const released = after.filter(({ fields }) => fields.chan1Raw === 0);
    assert.equal(released.length, 10);
    for (const { fields } of released) {
        for (let i = 1; i <= 18; ++i) {
            assert.equal(fields[`chan${i}Raw`], i <= 8 ? 0 : 65534);
        }
    }
    assert.equal(after.at(-1).fields.chan1Raw, 0);
});

test('what tribus sends as MANUAL_CONTROL is read', async () => {
    const { datagrams } = await sentWith('message = "manual_control"\nbuttons = 3', STICKS);
    const messages = (await messagesIn(datagrams)).filter(message => message.kind === 'MANUAL_CONTROL');
    assert.ok(messages.length > 40, `${messages.length} messages`);
    for (const { fields } of messages) {
        assert.deepEqual([fields.y, fields.x, fields.z, fields.r, fields.buttons], [-1000, 532, 1000, 0, 0b011]);
    }
});

function override(channels, target = 1) {
    const message = new common.RcChannelsOverride();
    message.targetSystem = target;
    message.targetComponent = 1;
    for (let i = 1; i <= 18; ++i) {
        message[`chan${i}Raw`] = channels[i - 1] ?? (i <= 8 ? 65535 : 0);
    }
    return message;
}

test('what node-mavlink sends is read, its last word only, and its end is a loss', async () => {
    const servos = await receiver();
    const input = await freeAddress();
    const from = { station: new MavLinkProtocolV2(255, 190), stranger: new MavLinkProtocolV2(42, 1) };
    let sequence = 0;
    const send = (protocol, message) => sendTo(servos.socket, input, protocol.serialize(message, sequence++ % 256));
    await withAppliance(`
[input.station]
protocol = "mavlink"
address  = "${input}"
sender   = "127.0.0.1"
message  = "rc_channels_override"
[output.servos]
protocol = "ibus"
address  = "${servos.address}"
channels = 14
[pipeline.main]
from = "station"
to   = "servos"
`, async () => {
        for (let i = 0; i < 150; ++i) {
            send(from.station, override([1000 + i, ...STICKS.slice(1)]));
            send(from.stranger, override(STICKS.map(() => 2000)));
            send(from.station, override(STICKS.map(() => 1111), 9));
            send(from.station, new common.Attitude());
            await sleep(10);
        }
        await sleep(50);
        assert.ok(servos.datagrams.length > 20, `${servos.datagrams.length} frames`);
        for (const datagram of servos.datagrams) {
            const [first, ...others] = ibusChannels(datagram);
            assert.ok(first >= 1000 && first <= 1149, `channel 1 is ${first}`);
            assert.deepEqual(others, STICKS.slice(1));
        }
        assert.equal(ibusChannels(servos.datagrams.at(-1))[0], 1149);
        await sleep(900);
        const silent = servos.datagrams.length;
        await sleep(300);
        assert.equal(servos.datagrams.length, silent, 'the output goes on after the loss');
    });
    servos.socket.close();
});

// An autopilot that takes overrides of its ground station only, and shows them in RC_CHANNELS.
async function logBesideAutopilot(lines, answers = true) {
    const autopilot = await receiver();
    const input = await freeAddress();
    const own = new MavLinkProtocolV2(1, 1);
    let sequence = 0;
    let channels = Array(18).fill(0);
    let station = null;
    const send = message => autopilot.socket.send(own.serialize(message, sequence++ % 256), station.port, station.address);
    autopilot.socket.on('message', async (datagram, from) => {
        station = from;
        for (const { kind, system, fields } of await messagesIn([datagram])) {
            if (kind === 'RC_CHANNELS_OVERRIDE' && system === 255) {
                channels = channels.map((_, i) => fields[`chan${i + 1}Raw`]);
            }
        }
    });
    const beats = setInterval(() => {
        if (station === null || !answers) {
            return;
        }
        const rc = new common.RcChannels();
        rc.chancount = 18;
        channels.forEach((pulse, i) => { rc[`chan${i + 1}Raw`] = pulse; });
        send(rc);
        const heartbeat = new minimal.Heartbeat();
        heartbeat.type = minimal.MavType.QUADROTOR;
        heartbeat.autopilot = minimal.MavAutopilot.ARDUPILOTMEGA;
        send(heartbeat);
    }, 100);
    const log = await withAppliance(`
[input.receiver]
protocol = "ibus"
address  = "${input}"
[output.drone]
protocol = "mavlink"
address  = "${autopilot.address}"
message  = "rc_channels_override"
${lines}
[pipeline.main]
from = "receiver"
to   = "drone"
`, async () => {
        for (let i = 0; i < 300; ++i) {
            const moving = [1000 + i, ...STICKS.slice(1)];
            sendTo(autopilot.socket, input, ibusFrame(moving));
            await sleep(10);
        }
    });
    clearInterval(beats);
    autopilot.socket.close();
    return log.split('\n').filter(line => line.includes('answers'));
}

test('the log says once that an autopilot answers but takes no overrides of this system', async () => {
    const lines = await logBesideAutopilot('system = 254\nchannels = 14');
    assert.equal(lines.length, 1, lines.join('\n'));
    assert.match(lines[0], /output drone: autopilot 1 answers, but .* must be 254/);
});

test('the log says nothing of it where the overrides have an effect, or nobody answers', async () => {
    assert.deepEqual(await logBesideAutopilot('channels = 14'), []);
    assert.deepEqual(await logBesideAutopilot('system = 254\nchannels = 14', false), []);
});

// Mission Planner makes a key of a passphrase so.
const KEY = MavLinkPacketSignature.key('a boat on a lake');

// Calls `work` with the path of a file that has the key.
async function withKeyFile(content, work) {
    const folder = mkdtempSync(join(tmpdir(), 'tribus-key-'));
    const file = join(folder, 'boat.key');
    writeFileSync(file, content, { mode: 0o600 });
    try {
        await work(file);
    } finally {
        rmSync(folder, { recursive: true });
    }
}

for (const [message, kind] of [['radio_rc_channels', 'RADIO_RC_CHANNELS'], ['rc_channels_override', 'RC_CHANNELS_OVERRIDE']]) {
    test(`what tribus signs as ${kind} and HEARTBEAT is genuine, with a new time each`, () => withKeyFile(KEY, async file => {
        const before = Date.now();
        const { datagrams } = await sentWith(
            `message = "${message}"\nchannels = 18\nkey = "${file}"\nlink_id = 5`, STICKS);
        const after = Date.now();
        const messages = await messagesIn(datagrams);
        assert.ok(messages.filter(one => one.kind === kind).length > 40, `${messages.length} messages`);
        assert.ok(messages.some(one => one.kind === 'HEARTBEAT'));
        let latest = 0;
        for (const { signature } of messages) {
            assert.ok(signature?.matches(KEY));
            assert.equal(signature.linkId, 5);
            assert.ok(signature.timestamp > latest);
            latest = signature.timestamp;
            const at = latest / 100 + MavLinkProtocolV2.SIGNATURE_START_TIME;
            assert.ok(at >= before - 1 && at <= after + 1, `${at}, not from ${before} to ${after}`);
        }
    }));
}

test('with a key only what node-mavlink signs with it counts, and only once', () => withKeyFile(KEY.toString('hex'), async file => {
    const servos = await receiver();
    const input = await freeAddress();
    const protocol = new MavLinkProtocolV2(255, 190, MavLinkProtocolV2.IFLAG_SIGNED);
    const unsigned = new MavLinkProtocolV2(255, 190);
    const start = Date.now();
    const forged = override(STICKS.map(() => 2000));
    const send = bytes => sendTo(servos.socket, input, bytes);
    await withAppliance(`
[input.station]
protocol = "mavlink"
address  = "${input}"
key      = "${file}"
[output.servos]
protocol = "ibus"
address  = "${servos.address}"
channels = 14
[pipeline.main]
from = "station"
to   = "servos"
`, async () => {
        const first = protocol.sign(protocol.serialize(override(STICKS.map(() => 1900)), 0), 3, KEY, start);
        send(first);
        await sleep(20);
        for (let i = 0; i < 150; ++i) {
            send(protocol.sign(protocol.serialize(override(STICKS), i), 3, KEY, start + 1000 + 10 * i));
            send(first);
            send(unsigned.serialize(forged, i));
            send(protocol.sign(protocol.serialize(forged, i), 3, MavLinkPacketSignature.key('another'), start + 5000 + 10 * i));
            send(protocol.sign(protocol.serialize(forged, i), 4, KEY, start - 3600000 + i));
            await sleep(10);
        }
        await sleep(50);
        const late = servos.datagrams.slice(-40);
        assert.equal(late.length, 40);
        late.forEach(datagram => assert.deepEqual(ibusChannels(datagram), STICKS));
        assert.ok(servos.datagrams.every(datagram => ibusChannels(datagram)[1] !== 2000));
    });
    servos.socket.close();
}));

test('signed messages are read by decode with their key, and by no other', () => withKeyFile(KEY, async file => {
    const protocol = new MavLinkProtocolV2(255, 190, MavLinkProtocolV2.IFLAG_SIGNED);
    const plain = protocol.serialize(override(STICKS), 0);
    const wrong = protocol.sign(plain, 0, MavLinkPacketSignature.key('another'));
    const right = protocol.sign(protocol.serialize(override(STICKS.map(() => 1600)), 0), 0, KEY);
    const lines = decode(Buffer.concat([wrong, right]), '--protocol', 'mavlink', '--key', file);
    const frames = lines.filter(line => line.channels);
    assert.equal(frames.length, 1);
    assert.equal(frames[0].channels[0], 1600);
    assert.equal(lines.at(-1).summary.rejected.wrong_signature, 1);
}));

test('each message with channels is read by decode, of both versions', () => {
    const rc = new common.RcChannels();
    rc.chancount = 14;
    const radio = new development.RadioRcChannels();
    radio.count = 14;
    radio.flags = development.RadioRcChannelsFlags.FAILSAFE;
    radio.channels = Array(32).fill(0);
    STICKS.forEach((pulse, i) => {
        rc[`chan${i + 1}Raw`] = pulse;
        radio.channels[i] = Math.round((pulse - 1500) * 32 / 5);
    });
    for (const [message, protocols, failsafe] of [
        [rc, [new MavLinkProtocolV1(), new MavLinkProtocolV2()], false],
        [override(STICKS), [new MavLinkProtocolV2()], false],
        [radio, [new MavLinkProtocolV2()], true],
    ]) {
        for (const protocol of protocols) {
            const [frame] = decode(protocol.serialize(message, 0), '--protocol', 'mavlink');
            assert.equal(frame.failsafe, failsafe);
            STICKS.forEach((pulse, i) => assert.ok(Math.abs(frame.channels[i] - pulse) < 0.13, `channel ${i + 1}`));
        }
    }
});

test('the values of an autopilot are read by decode', () => {
    const autopilot = new MavLinkProtocolV2(1, 1);
    const battery = new common.BatteryStatus();
    Object.assign(battery, { voltages: [4100, 4000, 3900, ...Array(7).fill(65535)], currentBattery: 1234,
        currentConsumed: 1500, batteryRemaining: 64, temperature: 2550 });
    const gps = new common.GpsRawInt();
    Object.assign(gps, { lat: 481371536, lon: -115753822, alt: 519123, vel: 1234, cog: 27150, fixType: 3,
        satellitesVisible: 14 });
    const attitude = new common.Attitude();
    Object.assign(attitude, { roll: 0.5, pitch: -0.25, yaw: 3 });
    const hud = new common.VfrHud();
    Object.assign(hud, { airspeed: 12.5, groundspeed: 4.5, heading: 90, throttle: 55, alt: 120, climb: -1.5 });
    const status = new common.SysStatus();
    Object.assign(status, { load: 250, voltageBattery: 12600, currentBattery: 345, batteryRemaining: 87 });
    const near = (value, wanted) => assert.ok(Math.abs(value - wanted) < 1e-3 * Math.abs(wanted), `${value}, not ${wanted}`);
    for (const [message, wanted] of [
        [battery, { 'battery.voltage': 12, 'battery.current': 12.34, 'battery.consumed': 1500,
            'battery.remaining': 64, 'battery.temperature': 25.5 }],
        [gps, { 'gps.latitude': 48.1371536, 'gps.longitude': -11.5753822, 'gps.altitude': 519.123,
            'gps.speed': 12.34, 'gps.heading': 271.5, 'gps.fix': 3, 'gps.satellites': 14 }],
        [attitude, { 'attitude.roll': 28.6479, 'attitude.pitch': -14.3239, 'attitude.yaw': 171.887 }],
        [hud, { 'hud.airspeed': 12.5, 'hud.groundspeed': 4.5, 'hud.heading': 90, 'hud.throttle': 55,
            'hud.altitude': 120, 'hud.climb': -1.5 }],
        [status, { 'system.load': 25, 'system.voltage': 12.6, 'system.current': 3.45, 'system.remaining': 87 }],
    ]) {
        const [{ values }] = decode(autopilot.serialize(message, 0), '--protocol', 'mavlink-telemetry');
        assert.deepEqual(Object.keys(values).sort(), Object.keys(wanted).sort());
        for (const [name, value] of Object.entries(wanted)) {
            near(values[name], value);
        }
    }
});
