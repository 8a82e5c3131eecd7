// Doctor, Learn and Recordings before the real daemon on ptys, with their bad ends.
import assert from 'node:assert/strict';
import { mkdtemp, rm } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { button, openBrowser, sees, waitLive, withBoard } from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 60_000;

test('doctor says what it found, and can be asked again', { timeout }, async () => {
    await withBoard(browser, { at: '#/boat/doctor' }, async ({ page }) => {
        await page.getByRole('heading', { name: 'Findings', exact: true }).waitFor();
        await button(page, 'Examine again').click();
        await page.getByRole('heading', { name: 'Ports', exact: true }).waitFor();
        await button(page, 'Examine again').and(page.locator(':enabled')).waitFor();
    });
});

test('learn of a port that the daemon has says so, and can begin again', { timeout }, async () => {
    await withBoard(browser, { at: '#/boat/learn' }, async ({ page }) => {
        await waitLive(page);
        await sees(page, 'sudo systemctl stop tribus@boat');
        await button(page, 'Start').click();
        await sees(page, 'Broken off');
        await sees(page, /another program uses it/);
        await button(page, 'Once more').click();
        await sees(page, /another program uses it/);
    });
});

test('without a recorder the page says how to get one', { timeout }, async () => {
    await withBoard(browser, { at: '#/boat/recordings' }, async ({ page }) => {
        await sees(page, /There is no recorder/);
    });
});

test('a recording is written, drawn and downloaded', { timeout }, async () => {
    const folder = await mkdtemp(join(tmpdir(), 'tribus-recordings-'));
    const map = `[recorder]\ndirectory = "${folder}"\non_failsafe = false\n`;
    await withBoard(browser, { at: '#/boat/recordings', map }, async ({ page, context }) => {
        await sees(page, 'No recording yet.');
        await button(page, 'Record now').click();
        await sees(page, /^Written to /);
        await page.getByRole('button', { name: /^Plot / }).click();
        await page.getByLabel('Channel').first().waitFor();
        await sees(page, /servos: control from/);
        const link = page.getByRole('link', { name: /^Download/ });
        const archive = await context.request.get(
            new URL(await link.getAttribute('href'), page.url()).href);
        assert.equal(archive.status(), 200);
        assert.equal((await archive.body()).subarray(257, 262).toString(), 'ustar');
    });
    await rm(folder, { recursive: true });
});
