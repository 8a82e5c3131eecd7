// The page in front of the real server and the real daemon: what every change must keep.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
    button, looksLive, openBrowser, sees, trialOf, typeInto, waitLive, whenItAges,
    withBoard as withReal,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 90_000;
const withBoard = (options, body) => withReal(browser, options, body);
const configuration = (page) => page.getByRole('link', { name: 'Configuration' }).click();
const live = (page) => page.getByRole('link', { name: 'Live' }).first().click();

test('sticks move before and after; map, reverse and preset are seen', { timeout }, async () => {
    const map = '[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n2 = { from = 4 }\n'
        + '[pipeline.main.failsafe]\nhold = "0s"\npreset = { 1 = 1111, other = 1500 }\n';
    await withBoard({ map }, async ({ page, board }) => {
        await sees(page, 'under control of receiver');
        const us = (row) => page.locator('table[data-pair=servos] tbody tr').nth(row)
            .locator('td.us').allInnerTexts();
        const shows = async (row, pair) => {
            await page.waitForFunction(([at, wanted]) => {
                const cells = document.querySelectorAll('table[data-pair=servos] tbody tr')[at]
                    .querySelectorAll('td.us');
                return [...cells].map((e) => e.innerText).join() === wanted;
            }, [row, pair.join()]).catch(() => {});
            assert.deepEqual(await us(row), pair);
        };
        await shows(0, ['1100', '1900']);
        board.setPulses([1234, 1500, 1500, 1777]);
        await shows(0, ['1234', '1766']);
        await shows(1, ['1500', '1777']);
        await board.servos('control 1766 1777 1500 1777');
        board.cutWire(true);
        await page.locator('.bar.preset').first().waitFor();
        assert.equal(await page.locator('.bar.preset .label').first().innerText(), 'preset');
        assert.equal((await us(0))[1], '1111');
    });
});

/** Notes when each state of the output is drawn first, on the wall clock, until `last` is. */
const watch = (page, last) => page.evaluate((until) => {
    globalThis.drawn = new Promise((done) => {
        const seen = { worst: 0 };
        let before = performance.now();
        const look = () => {
            const now = performance.now();
            seen.worst = Math.max(seen.worst, now - before);
            before = now;
            const sentence = document.querySelector('.sentence');
            const { state } = sentence.dataset;
            seen[state] ??= { at: Date.now(), text: sentence.innerText };
            if (state === until) {
                done(seen);
            } else {
                requestAnimationFrame(look);
            }
        };
        look();
    });
}, last);

/** How many ms the page was behind the log when the wire was cut; then the wire works again. */
async function cutWire({ page, board }) {
    const from = board.log.text.length;
    await watch(page, 'failsafe');
    board.cutWire(true);
    const { hold, failsafe, worst } = await page.evaluate(() => globalThis.drawn);
    assert.match(hold.text, /holding the last values.*wire silent \(no bytes any more\)/s);
    assert.match(failsafe.text, /in failsafe.*wire silent/s);
    const late = Math.max(hold.at - await board.logged(/servos: holding/, from),
        failsafe.at - await board.logged(/servos: in failsafe/, from));
    console.log(`${late} ms after the log; the page drew every ${Math.round(worst)} ms at worst`);
    await watch(page, 'control');
    const mended = Date.now();
    board.cutWire(false);
    const { control } = await page.evaluate(() => globalThis.drawn);
    assert.match(control.text, /under control of receiver/);
    assert.ok(control.at - mended > 600, `control ${control.at - mended} ms after the mend`);
    return late - worst;
}

test('a cut wire is hold, failsafe with its cause, then control again', { timeout }, async () => {
    const map = '[pipeline.main.failsafe]\nhold = "1s"\nrecover = "700ms"\n';
    await withBoard({ map }, async (view) => {
        await sees(view.page, 'under control of receiver');
        // Other work on the machine only makes it later, so the least of some runs counts.
        const late = [await cutWire(view)];
        while (late.at(-1) >= 300 && late.length < 3) {
            late.push(await cutWire(view));
        }
        assert.ok(late.at(-1) < 300, `${late} ms after the log`);
    });
});

const STOPS = {
    daemon: ({ board }) => [board.daemon, 'SIGSTOP', 'SIGCONT'],
    server: ({ board }) => [board.server, 'SIGSTOP', 'SIGCONT'],
    link: ({ relay }) => [{ kill: (what) => relay[what]() }, 'cut', 'mend'],
};

test('a daemon, a server or a link that hangs is never shown as live', { timeout }, async () => {
    await withBoard({}, async (view) => {
        const { page, board } = view;
        for (const [name, parts] of Object.entries(STOPS)) {
            await waitLive(page);
            board.sweep();
            await page.waitForTimeout(300);
            const [one, stop, go] = parts(view);
            const times = page.evaluate(whenItAges);
            one.kill(stop);
            const { late, stale, worst } = await times;
            console.log(`${name}: grey after ${Math.round(late ?? stale)} ms, banner after `
                + `${Math.round(stale)} ms; the page looked every ${Math.round(worst)} ms`);
            // The page looks every 50 ms; a status may be 100 ms old before a bar moves.
            assert.ok((late ?? stale) < 500 + 150 + worst, `${name}: grey after ${late} ms`);
            assert.ok(stale < 1000 + 150 + worst, `${name}: banner after ${stale} ms`);
            await page.getByTestId('stale').waitFor();
            assert.deepEqual(await looksLive(page), [], name);
            assert.match(await page.locator('.said').first().innerText(), /^Last known:/);
            one.kill(go);
        }
        await waitLive(page);
        assert.equal(await page.getByTestId('stale').isVisible(), false);
    });
});

test('completion, mistake, diff, trial, kept, reload by hand', { timeout }, async () => {
    await withBoard({}, async ({ page, board }) => {
        const before = await board.text();
        await configuration(page);
        await typeInto(page, '\n[pipeline.main.channels]\n1 = { from = 1, revers = true }\n');
        const lines = await page.locator('.cm-line').allInnerTexts();
        const line = lines.findIndex((one) => one.includes('revers')) + 1;
        const column = '1 = { from = 1, '.length + 1;
        await button(page, new RegExp(`^${line}:${column}: .*revers`)).click();
        assert.equal(await page.locator('.cm-lintRange-error').innerText(), 'revers');
        assert.equal(await button(page, 'Try for 30 s').isDisabled(), true);
        for (let i = 0; i < 'revers'.length; ++i) {
            await page.keyboard.press('ArrowRight');
        }
        await page.keyboard.insertText('e');
        await sees(page, /channel 1: channel 1 before, now channel 1, reverse/);
        await typeInto(page, '\n[pipeline.main.failsafe]\n');
        await page.keyboard.type('hol');
        await page.locator('.cm-tooltip-autocomplete').getByText('hold').first().waitFor();
        await page.waitForTimeout(150);
        await page.keyboard.press('Enter');
        await page.keyboard.type('"200ms"');
        await sees(page, /hold: 300ms before, now 200ms/);
        await button(page, 'Try for 30 s').click();
        await trialOf(page).getByText(/On trial: \d+ s left/).waitFor();
        assert.equal(await board.text(), before);
        await board.servos('control 1900 1500 1500 1500');
        await live(page);
        await sees(page, /^1900$/);
        await button(page, 'Keep').click();
        await trialOf(page).getByText(/Kept/).waitFor();
        const kept = await board.text();
        assert.match(kept, /reverse = true \}\n+\[pipeline.main.failsafe\]\nhold = "200ms"/);
        await board.write(kept.replace('reverse = true', 'reverse = false'));
        await board.reload();
        await sees(page, /^1100$/);
        await configuration(page);
        await sees(page, 'reverse = false');
        await sees(page, 'The same as what runs.');
        // The same while the screen is open.
        await board.write(kept.replace('200ms', '250ms'));
        await board.reload();
        await sees(page, '250ms');
        await sees(page, 'The same as what runs.');
    });
});

/** Asks the server as the page would, without its buttons. */
const ask = (page, path, body, headers = {}) => page.evaluate(async ([to, content, more]) => {
    const answer = await fetch(to, { method: 'POST', body: JSON.stringify(content),
        headers: { 'Content-Type': 'application/json', 'X-Tribus': '1', ...more } });
    return { status: answer.status, ...await answer.json() };
}, [path, body, headers]);
const fileTag = (page) => page.evaluate(async () =>
    (await fetch('/api/boat/configuration')).headers.get('ETag'));

test('two tabs: the second merges; an old tab keeps nothing', { timeout }, async () => {
    await withBoard({}, async ({ page, board, relay, context, address }) => {
        const other = await context.newPage();
        await other.goto(`${address}#/boat/config`);
        await configuration(page);
        await typeInto(other, '# second\n');
        await sees(other, 'The same as what runs.');
        await typeInto(page, '# first\n');
        await button(page, 'Try for 30 s').click();
        await button(page, 'Keep').click();
        await trialOf(page).getByText(/Kept/).waitFor();
        await button(other, 'Try for 30 s').click();
        await sees(other, 'The file was changed by another meanwhile');
        await other.getByLabel('Both, theirs first').check();
        await button(other, 'Edit the merged text').click();
        await button(other, 'Try for 30 s').click();
        await trialOf(other).getByText(/On trial: \d+ s left/).waitFor();
        await button(other, 'Keep').click();
        await trialOf(other).getByText(/Kept/).waitFor();
        assert.match(await board.text(), /# first\n# second\n$/);

        // The first tab has a trial and hears nothing more of it; meanwhile another begins.
        await typeInto(page, '# third\n', 'Home');
        await button(page, 'Try for 30 s').click();
        await sees(page, 'The file was changed by another meanwhile');
        await button(page, 'Edit the merged text').click();
        await button(page, 'Try for 30 s').click();
        await trialOf(page).getByText(/On trial: \d+ s left/).waitFor();
        const text = await board.text();
        const tag = await fileTag(other);
        const { trial } = await other.evaluate(async () =>
            (await fetch('/api/boat/status')).json());
        relay.cutStreams();
        assert.equal((await ask(other, '/api/boat/back', { trial })).status, 200);
        const next = await ask(other, '/api/boat/draft', { toml: `${text}# theirs\n`, seconds: 30 },
            { 'If-Match': tag });
        assert.equal(next.trial, trial + 1);
        await button(page, 'Keep').click();
        await trialOf(page).getByText(/that trial is over; the present one is number \d+/).waitFor();
        assert.equal(await board.text(), text);
        assert.equal((await ask(other, '/api/boat/back', { trial: next.trial })).status, 200);
    });
});

test('a configuration that does not start is mended from the page', { timeout }, async () => {
    const text = (wires) => `[input.receiver]\nprotocol = "ibuz"\ndevice = "${wires.receiver}"\n\n`
        + `[output.servos]\nprotocol = "sbus"\ndevice = "${wires.servos}"\n\n`
        + '[pipeline.main]\nfrom = "receiver"\nto = "servos"\n';
    await withBoard({ text }, async ({ page, board }) => {
        await board.log.says(/ibuz/);
        await page.getByTestId('absent').waitFor();
        assert.equal(await page.locator('td.us').count(), 0);
        await page.getByRole('link', { name: 'Open the configuration' }).click();
        await button(page, /^2:12: .*ibuz/).click();
        assert.equal(await page.locator('.cm-lintRange-error').innerText(), '"ibuz"');
        assert.equal(await button(page, 'Write to the file').isDisabled(), true);
        await page.keyboard.press('Shift+End');
        await page.keyboard.insertText('"ibus"');
        await button(page, 'Write to the file').click();
        await sees(page, 'Written to the file.');
        assert.match(await board.text(), /^\[input.receiver\]\nprotocol = "ibus"\n/);
        await board.runDaemon();
        await live(page);
        await waitLive(page);
        await sees(page, 'under control of receiver');
    });
});
