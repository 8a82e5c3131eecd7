// The state of the simulated board; tests change it directly.
import { readFileSync } from 'node:fs';
import { Refusal } from './http.mjs';
import { statusOf } from './status.mjs';

const FILE = `# The boat: i.Bus in, SBUS out.
[input.receiver]
protocol = "ibus"
device   = "/dev/ttyAMA5"
timeout  = "100ms"

[output.servos]
protocol = "sbus"
device   = "/dev/ttyAMA3"

[pipeline.main]
from = "receiver"
to   = "servos"

[pipeline.main.failsafe]
hold   = "300ms"
preset = { 3 = 988, other = 1500 }
`;

export class Board {
    paired = true;
    role = 'change';
    public = false;
    code = '7K3M9QPA';
    /** False: streams stay open and bring nothing. */
    sends = true;
    gone = null;
    recorder = true;
    /** So many plots are refused because another is made. */
    busyPlots = 0;
    scenes = { boat: 'good', rover: 'good' };
    daemons = [
        { name: 'boat', state: 'running', file: '/etc/tribus/boat.toml' },
        { name: 'rover', state: 'running', file: '/etc/tribus/rover.toml' },
        { name: 'spare', state: 'absent', file: '/etc/tribus/spare.toml' },
    ];
    /** What changed from status to status, by daemon. */
    changes = {};
    /** Overrides fields of every status. */
    extra = {};
    files = {};
    schema = { type: 'object', properties: {} };
    recordings = [
        recording('2026-11-23T23-23-27Z-failsafe', 'failsafe', 123_456),
        recording('2026-11-22T10-00-01Z-request', 'request', 2_345_678),
    ];
    records = [];
    learnStep = 'none';
    streams = new Set();
    requests = [];

    constructor(schemaFile) {
        if (schemaFile) {
            this.schema = JSON.parse(readFileSync(schemaFile, 'utf8'));
        }
        for (const { name } of this.daemons) {
            this.files[name] = { text: FILE, version: 1, trial: null, history: [
                { id: 'a1', time: '2026-11-26T04:10:00Z', bytes: FILE.length, text: FILE }] };
        }
    }

    fileOf(name) {
        return this.files[name];
    }

    tagOf(name) {
        return `f${this.files[name].version}`;
    }

    /** Somebody else changes the file. */
    changeByAnother(name, text) {
        this.files[name].text = text;
        this.files[name].version += 1;
    }

    status(name) {
        const trial = this.trialOf(name);
        const status = statusOf(name, this.scenes[name] ?? 'good', performance.now() / 1000, {
            trial: trial?.number ?? null,
            trial_left_us: trial ? Math.round((trial.until - performance.now()) * 1000) : null,
            fingerprint: this.tagOf(name),
            ...this.extra,
        });
        return { ...status, changes: this.noteChanges(status).length };
    }

    noteChanges({ name, t_us, inputs, outputs }) {
        const told = this.changes[name] ??= { words: {}, list: [] };
        const look = (part, field, one) => {
            const key = `${part} ${one.name}`;
            const was = told.words[key] ?? one[field];
            told.words[key] = one[field];
            if (was !== one[field]) {
                told.list.push({ type: 'change', number: told.list.length + 1, t_us, part,
                    name: one.name, field, was, now: one[field] });
            }
        };
        inputs?.forEach((one) => look('input', 'cause', one));
        outputs?.forEach((one) => look('output', 'state', one));
        return told.list;
    }

    trialOf(name) {
        const file = this.files[name];
        if (file?.trial && file.trial.until < performance.now()) {
            file.trial = null;
        }
        return file?.trial ?? null;
    }

    startTrial(name, toml, seconds) {
        this.lastTrial = (this.lastTrial ?? 3) + 1;
        this.files[name].trial = {
            number: this.lastTrial, toml, until: performance.now() + seconds * 1000,
        };
        return this.lastTrial;
    }

    endTrial(name, number) {
        const trial = this.trialOf(name);
        if (!trial || trial.number !== number) {
            throw new Refusal(409, 'This trial is over, or another one runs.');
        }
        this.files[name].trial = null;
        return trial;
    }
}

function recording(id, cause, bytes) {
    const time = `${id.slice(0, 10)}T${id.slice(11, 19).replaceAll('-', ':')}Z`;
    return { id, time, cause, bytes };
}

/** As the checker would: "nonsense" is no key, a table needs its bracket. */
export function mistakesOf(toml) {
    return toml.split('\n').flatMap((line, i) => {
        const at = line.indexOf('nonsense');
        if (at >= 0) {
            return [{ line: i + 1, column: at + 1,
                text: 'unknown key "nonsense"; allowed: "protocol", "device", "timeout"' }];
        }
        return /^\[[^\]]*$/.test(line)
            ? [{ line: i + 1, column: line.length + 1, text: 'a table ends with "]"' }] : [];
    });
}
