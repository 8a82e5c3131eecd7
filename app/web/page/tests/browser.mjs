// One browser and one mock for a test file.
import { chromium } from 'playwright-core';
import { startMock } from '../mock.mjs';

const ARGUMENTS = [
    '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--disable-component-update', '--disable-sync',
];
const TIMEOUT_MS = 15_000;

export async function openBrowser() {
    return chromium.launch({
        executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ARGUMENTS,
        timeout: 60_000,
    });
}

/** A page of its own on a mock of its own; `close` ends both. */
export async function openPage(browser, options = {}) {
    const mock = await startMock({ schema: options.schema });
    options.board?.(mock.board);
    const context = await browser.newContext({
        viewport: { width: options.width ?? 1280, height: options.height ?? 900 },
        colorScheme: options.scheme ?? 'dark',
        reducedMotion: options.reducedMotion ?? 'no-preference',
        bypassCSP: options.bypassCSP ?? false,
    });
    context.setDefaultTimeout(TIMEOUT_MS);
    const page = await context.newPage();
    const problems = [];
    page.on('pageerror', (error) => problems.push(String(error)));
    page.on('console', (message) => {
        if (/content security policy/i.test(message.text())) {
            problems.push(message.text());
        }
    });
    await page.goto(mock.address + (options.at ?? ''), { timeout: TIMEOUT_MS });
    return {
        page, problems, board: mock.board,
        async close() {
            await context.close();
            mock.close();
        },
    };
}

export const lampText = (page) => page.getByTestId('lamp').innerText();

export async function waitLive(page) {
    await page.locator('.lamp.live').waitFor();
}
