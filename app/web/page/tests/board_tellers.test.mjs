// Whatever happens to a real board, the page says of each part what the daemon's status says.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import { openBrowser, waitLive, withBoard } from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 180_000;
const STEPS = 12;

/** Numbers run on between two questions. */
const still = (text) => (text ?? '').replace(/\d+(\.\d+)?/g, '#').replace(/# (us|ms|s|min # s)/g, '# s');

/** What the page shows of each part, and what the status says at about that time; runs in the page. */
async function bothOf() {
    const status = await (await fetch('/api/boat/status')).json();
    const text = (place) => document.querySelector(place)?.innerText.replace(/\s+/g, ' ').trim();
    const fact = (name) => [...document.querySelectorAll('.fact')]
        .find((one) => one.querySelector('dt').innerText.startsWith(name))
        ?.querySelector('dd').innerText.replace(/\s+/g, ' ').trim();
    return {
        status,
        outputs: status.outputs.map(({ name }) => ({
            look: document.querySelector(`.sentence[data-output=${name}]`)?.dataset.state,
            said: text(`.sentence[data-output=${name}] .said`),
            why: text(`.sentence[data-output=${name}] .why`),
        })),
        inputs: status.inputs.map(({ name }) => fact(name)),
        ports: status.ports.map(({ name, kind }) => fact(kind === 'can' ? `CAN ${name}` : name)),
    };
}

/** Empty if the page says of each part what the status says, else what differs. */
function differences({ status, outputs, inputs, ports }) {
    const wrong = [];
    const expect = (what, shown, right) => right || wrong.push(`${what}: the page has "${shown}"`);
    status.outputs.forEach((output, i) => {
        const { look, said, why } = outputs[i];
        const waits = look === 'waiting';
        expect(`${output.name} ${output.state}`, look, look === output.state || waits);
        expect(output.text, said, still(said) === still((waits ? 'waiting: ' : '') + output.text));
        expect(output.why, why, still(why) === still(output.why));
    });
    status.inputs.forEach((input, i) =>
        expect(input.text, inputs[i], still(inputs[i]).startsWith(still(input.text))));
    status.ports.forEach((port, i) =>
        expect(port.text, ports[i], still(ports[i]).startsWith(still(port.text))));
    return wrong;
}

/** Sooner than a state ends by itself: what the page said of it would never be compared. */
async function expectAgreement(page, step) {
    const TRIES = 20;
    let wrong;
    for (let i = 0; i < TRIES; ++i) {
        wrong = differences(await page.evaluate(bothOf));
        if (wrong.length === 0) {
            return;
        }
        await page.waitForTimeout(100);
    }
    assert.deepEqual(wrong, [], step);
}

/** Numbers below `most`, the same in each run. */
function randomOf(seed) {
    let state = seed;
    return (most) => {
        state = (state * 1103515245 + 12345) % 2 ** 31;
        return Math.floor(state / 65536) % most;
    };
}

const CONFIGURATIONS = {
    'presets at once': '[pipeline.main.failsafe]\nhold = "0s"\n',
    'values held': '[pipeline.main.failsafe]\nhold = "5s"\n',
    'silence, slow recovery': '[pipeline.main.failsafe]\nhold = "500ms"\naction = "silence"\nrecover = "3s"\n',
};

describe('the page agrees with the status', { concurrency: 3 }, () => {
    Object.entries(CONFIGURATIONS).forEach(([name, map], seed) => {
        test(name, { timeout }, async () => {
            await withBoard(browser, { map }, async ({ page, board, problems }) => {
                await waitLive(page);
                const below = randomOf(seed + 1);
                const seen = new Set();
                let cut = false;
                for (let step = 0; step < STEPS; ++step) {
                    const what = below(4);
                    if (what === 0) {
                        await board.runDaemon();
                        await waitLive(page);
                    } else {
                        cut = !cut;
                        board.cutWire(cut);
                    }
                    await page.waitForTimeout(below(1500));
                    await expectAgreement(page, `step ${step}: ${what === 0 ? 'started' : cut}`);
                    seen.add((await page.evaluate(bothOf)).outputs[0].look);
                }
                assert.ok(seen.size > 1, `only ${[...seen]} was seen`);
                problems.length = 0; // a status that was asked while no daemon ran
            });
        });
    });
});
