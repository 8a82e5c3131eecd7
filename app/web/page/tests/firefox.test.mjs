// The same page in Firefox, by WebDriver BiDi, before the real daemon: sticks, hangs, a trial kept.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import puppeteer from 'puppeteer-core';
import { startBoard, until } from './board.mjs';
import { whatLooksLive, whenItAges } from './browser.mjs';
import { startRelay } from './relay.mjs';

const PATIENCE_MS = 30_000;
const timeout = 120_000;

let browser;
before(async () => {
    browser = await puppeteer.launch({ browser: 'firefox', protocol: 'webDriverBiDi',
        executablePath: process.env.FIREFOX ?? '/usr/bin/firefox-esr', headless: true,
        timeout: 90_000 });
});
after(async () => { await browser?.close(); });

const textOf = (page) => page.evaluate(() => document.body.innerText);
/** Waits until the text of the page matches. */
const sees = (page, pattern) => until(async () => pattern.exec(await textOf(page)),
    () => `${pattern} on the page`, PATIENCE_MS);
const waitLive = (page) => page.waitForSelector('.lamp.live', { timeout: PATIENCE_MS });

/** Clicks the button or link of that name. */
async function click(page, name) {
    const found = await page.waitForSelector(
        `::-p-aria([name="${name}"])`, { timeout: PATIENCE_MS, visible: true });
    await until(() => found.evaluate((e) => !e.disabled), () => `${name} enabled`, PATIENCE_MS);
    await found.click();
}

/** Types at the end of the editor. */
async function typeAtEnd(page, text) {
    await page.waitForSelector('.editor', { timeout: PATIENCE_MS });
    const content = await until(
        () => page.evaluateHandle(() => document.querySelector('.editor').shadowRoot
            ?.querySelector('.cm-content')).then((handle) => handle.asElement()),
        () => 'the editor', PATIENCE_MS);
    await content.click();
    await page.keyboard.down('Control');
    await page.keyboard.press('End');
    await page.keyboard.up('Control');
    await page.keyboard.type(text);
    return content;
}

async function withBoard(body) {
    const board = await startBoard();
    const relay = await startRelay(board.port);
    const context = await browser.createBrowserContext();
    try {
        const page = await context.newPage();
        await page.setViewport({ width: 1280, height: 900 });
        await page.goto(`http://127.0.0.1:${relay.port}/`, { timeout: PATIENCE_MS });
        await (await page.waitForSelector('#code', { timeout: PATIENCE_MS })).type(
            await board.code());
        await page.keyboard.press('Enter');
        await waitLive(page);
        await body({ page, board, relay, context });
    } finally {
        await context.close();
        relay.close();
        await board.close();
    }
}

test('Firefox: sticks move before and after', { timeout }, async () => {
    await withBoard(async ({ page, board }) => {
        await sees(page, /under control of receiver/);
        board.setPulses([1234, 1777]);
        const rows = () => page.evaluate(() => [0, 1].map((row) =>
            [...document.querySelectorAll('table[data-pair=servos] tbody tr')[row]
                .querySelectorAll('td.us')].map((e) => e.innerText)));
        await until(async () => (await rows())[1][1] === '1777', () => 'a moved stick');
        assert.deepEqual(await rows(), [['1234', '1234'], ['1777', '1777']]);
    });
});

test('Firefox: what hangs is never shown as live', { timeout }, async () => {
    await withBoard(async ({ page, board, relay }) => {
        const stops = {
            daemon: [() => board.daemon.kill('SIGSTOP'), () => board.daemon.kill('SIGCONT')],
            server: [() => board.server.kill('SIGSTOP'), () => board.server.kill('SIGCONT')],
            link: [() => relay.cut(), () => relay.mend()],
        };
        for (const [name, [stop, go]] of Object.entries(stops)) {
            await waitLive(page);
            board.sweep();
            await new Promise((later) => { setTimeout(later, 300); });
            const times = page.evaluate(whenItAges);
            stop();
            const { late, stale, worst } = await times;
            console.log(`${name}: grey after ${Math.round(late ?? stale)} ms, banner after `
                + `${Math.round(stale)} ms; the page looked every ${Math.round(worst)} ms`);
            assert.ok((late ?? stale) < 500 + 150 + worst, `${name}: grey after ${late} ms`);
            assert.ok(stale < 1000 + 150 + worst, `${name}: banner after ${stale} ms`);
            assert.deepEqual(await page.evaluate(whatLooksLive), [], name);
            go();
        }
        await waitLive(page);
    });
});

test('Firefox: completion, mistake, trial, kept, reload by hand', { timeout }, async () => {
    await withBoard(async ({ page, board }) => {
        const before = await board.text();
        await click(page, 'Configuration');
        await sees(page, /The same as what runs/);
        const content = await typeAtEnd(page, '[pipeline.main.failsafe]\nhol');
        const completions = () => content.evaluate((e) => e.getRootNode()
            .querySelector('.cm-tooltip-autocomplete')?.textContent ?? '');
        await until(async () => /hold/.test(await completions()), () => 'a completion');
        await new Promise((later) => { setTimeout(later, 150); });
        await page.keyboard.press('Enter');
        await page.keyboard.type('"200ms"\nhold_ = 1');
        const [, line, column] = await sees(page, /(\d+):(\d+): [^\n]*hold_/);
        const lines = await content.evaluate((e) => [...e.querySelectorAll('.cm-line')]
            .map((one) => one.textContent));
        assert.equal(lines[line - 1].slice(column - 1), 'hold_ = 1');
        for (let i = 0; i < 'hold_ = 1'.length; ++i) {
            await page.keyboard.press('Backspace');
        }
        await sees(page, /hold: 300ms before, now 200ms/);
        await click(page, 'Try for 30 s');
        await sees(page, /On trial: \d+ s left/);
        assert.equal(await board.text(), before);
        await click(page, 'Keep');
        await sees(page, /Kept/);
        const kept = await board.text();
        assert.match(kept, /hold = "200ms"/);
        await board.write(`${kept}\n[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n`);
        await board.reload();
        await until(async () => /reverse = true/.test(
            await content.evaluate((e) => e.textContent)), () => 'the new text', PATIENCE_MS);
        await click(page, 'Live');
        await sees(page, /1900/);
    });
});

test('Firefox: a tab behind another closes its stream', { timeout }, async () => {
    await withBoard(async ({ page, relay, context }) => {
        const streams = (count) => until(() => relay.streams() === count,
            () => `${count} streams, of ${relay.streams()}`, PATIENCE_MS);
        await streams(1);
        const other = await context.newPage();
        await other.bringToFront();
        await until(() => page.evaluate(() => document.hidden), () => 'a hidden tab', PATIENCE_MS);
        await streams(0);
        await page.bringToFront();
        await waitLive(page);
        await streams(1);
    });
});
