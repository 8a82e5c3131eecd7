// What all tests in Chromium share: a browser, and pages on the mock or on a real board.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';
import { chromium } from 'playwright-core';
import { startMock } from '../mock.mjs';
import { startBoard } from './board.mjs';
import { startRelay } from './relay.mjs';

const ARGUMENTS = [
    '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync',
    // Names of the board, and of a host whose owner lets it resolve to the board.
    '--host-resolver-rules=MAP board.local 127.0.0.1, MAP evil.example 127.0.0.1',
];
const TIMEOUT_MS = 15_000;

export async function openBrowser() {
    return chromium.launch({
        executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ARGUMENTS,
        timeout: 60_000,
    });
}

async function openContext(browser, options) {
    const context = await browser.newContext({
        viewport: { width: options.width ?? 1280, height: options.height ?? 900 },
        colorScheme: options.scheme ?? 'dark',
        reducedMotion: options.reducedMotion ?? 'no-preference',
    });
    context.setDefaultTimeout(TIMEOUT_MS);
    return context;
}

/** Keeps what scripts of a page throw, and what its security policy refuses. */
export function watchProblems(page) {
    const problems = [];
    page.on('pageerror', (error) => problems.push(String(error)));
    page.on('console', (message) => {
        if (/content security policy/i.test(message.text())) {
            problems.push(message.text());
        }
    });
    return problems;
}

/** A page of its own on a mock of its own; `close` ends both. */
export async function openPage(browser, options = {}) {
    const mock = await startMock({ schema: options.schema });
    options.board?.(mock.board);
    const context = await openContext(browser, options);
    const page = await context.newPage();
    const problems = watchProblems(page);
    await page.goto(mock.address + (options.at ?? ''), { timeout: TIMEOUT_MS });
    return {
        page, problems, board: mock.board,
        async close() {
            await context.close();
            mock.close();
        },
    };
}

/** Runs `body` with a page on a mock. */
export async function withPage(browser, options, body) {
    const view = await openPage(browser, options);
    try {
        await body(view);
        assert.deepEqual(view.problems, []);
    } finally {
        await view.close();
    }
}

export async function pairBy(page, code) {
    await page.getByLabel('Code', { exact: true }).fill(code);
    await page.getByRole('button', { name: 'Pair' }).click();
}

/**
 * A page on a real board, behind a wire that the test can cut. `pairs`: words for `tribus pair`, or
 * false; `at`: where the page begins once it is paired; `host`: by which name it is reached.
 */
export async function openBoard(browser, options = {}) {
    const board = await startBoard(options);
    const relay = await startRelay(board.port);
    const context = await openContext(browser, options);
    const close = async () => {
        await context.close();
        relay.close();
        await board.close();
    };
    try {
        const address = `http://${options.host ?? '127.0.0.1'}:${relay.port}/`;
        const foreign = [];
        context.on('request', (request) => {
            if (!request.url().startsWith(address) && !request.url().startsWith('data:')) {
                foreign.push(request.url());
            }
        });
        const page = await context.newPage();
        const problems = watchProblems(page);
        await page.goto(address + (options.at ?? ''), { timeout: TIMEOUT_MS });
        if (options.pairs !== false) {
            await pairBy(page, await board.code(...(options.pairs ?? [])));
            await page.locator('.lamp').waitFor();
        }
        return { page, problems, foreign, board, relay, context, address, close };
    } catch (error) {
        await close();
        throw error;
    }
}

/** Runs `body` with a page on a real board. No request may leave it. */
export async function withBoard(browser, options, body) {
    const view = await openBoard(browser, options);
    try {
        await body(view);
        assert.deepEqual(view.problems, []);
        assert.deepEqual(view.foreign, [], 'a request left the origin');
    } finally {
        await view.close();
    }
}

export const lampText = (page) => page.getByTestId('lamp').innerText();

export async function waitLive(page) {
    await page.locator('.lamp.live').waitFor();
}

export const sees = (page, text) => page.getByText(text).first().waitFor();
export const button = (page, name) => page.getByRole('button', { name, exact: true });
export const trialOf = (page) => page.getByTestId('trial');

/** Puts the cursor there and types: `end` is "Home" or "End" of the text. */
export async function typeInto(page, text, end = 'End') {
    await page.locator('.cm-content').click();
    await page.keyboard.press(`Control+${end}`);
    await page.keyboard.insertText(text);
}

/** What of the page still looks as if it were live; runs in the page. */
export function whatLooksLive() {
    const struck = (e) => {
        for (let up = e; up; up = up.parentElement) {
            if (getComputedStyle(up).textDecorationLine.includes('line-through')) {
                return true;
            }
        }
        return false;
    };
    const numbers = [...document.querySelectorAll('main td.us *, main dd, .said .value')]
        .filter((e) => e.textContent !== '' && e.textContent !== 'none' && !struck(e));
    const fills = [...document.querySelectorAll('.bar:not(.none) .fill')].filter((e) =>
        getComputedStyle(e).backgroundColor !== 'rgba(0, 0, 0, 0)'
        || getComputedStyle(e).backgroundImage !== 'none');
    return [...numbers.map((e) => e.textContent), ...fills.map(() => 'bar')];
}

export const looksLive = (page) => page.evaluate(whatLooksLive);

/**
 * After how many ms without a moving bar the page became grey, and stale; runs in the page, which
 * may be late by `worst` because the machine has other work.
 */
export function whenItAges() {
    return new Promise((done) => {
        const seen = { worst: 0 };
        let last = performance.now();
        let tick = last;
        new MutationObserver(() => { last = performance.now(); }).observe(
            document.querySelector('.fill'), { attributes: true });
        const timer = setInterval(() => {
            const now = performance.now();
            seen.worst = Math.max(seen.worst, now - tick);
            tick = now;
            const level = document.querySelector('.frame').dataset.level;
            if (level === 'live') {
                delete seen.late;
                delete seen.stale;
            } else {
                seen[level] ??= now - last;
            }
            if (seen.stale) {
                clearInterval(timer);
                done(seen);
            }
        }, 5);
    });
}

/** How much wider than the window the page is, in px. */
export const tooWide = (page) => page.evaluate(() =>
    document.documentElement.scrollWidth - document.documentElement.clientWidth);

let axe;
/** What axe finds. The page loads nothing from elsewhere, so axe comes in as text. */
export async function violations(page) {
    axe ??= await readFile(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
    await page.evaluate(axe);
    const found = await page.evaluate(() => globalThis.axe.run(document));
    return found.violations.flatMap((one) =>
        one.nodes.map((node) => `${one.id}: ${node.target} ${node.failureSummary}`));
}

/** Presses Tab until the focus is on the named thing. */
export async function tabTo(page, name) {
    for (let i = 0; i < 60; i += 1) {
        await page.keyboard.press('Tab');
        const here = await page.evaluate(() => {
            const deep = (root) => root.activeElement?.shadowRoot
                ? deep(root.activeElement.shadowRoot) : root.activeElement;
            const e = deep(document);
            return `${e?.getAttribute('aria-label') ?? ''} ${e?.textContent?.slice(0, 60) ?? ''}`;
        });
        if (here.includes(name)) {
            return;
        }
    }
    assert.fail(`Tab does not reach ${name}`);
}
