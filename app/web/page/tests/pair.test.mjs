// Pairing, and what a page shows that cannot be loaded.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, pairBy as type, waitLive, withPage as withMock } from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 60_000;

const withPage = (options, body) => withMock(browser, options, body);
const unpaired = (board) => { board.paired = false; };

test('a code pairs, also in small letters with a space', { timeout }, async () => {
    await withPage({ board: unpaired }, async ({ page }) => {
        await type(page, '7k3m 9qpa');
        await waitLive(page);
    });
});

test('wrong codes: when the next one counts, then a new code is needed', { timeout }, async () => {
    await withPage({ board: unpaired }, async ({ page, board }) => {
        await type(page, 'SHORT');
        await page.getByText('A code has 8 letters and digits.').waitFor();
        await type(page, 'AAAAAAAA');
        await page.getByText('The next one counts in 2 s.').waitFor();
        board.code = null;
        await type(page, 'AAAAAAAA');
        await page.getByText('Run sudo tribus pair on the board again').waitFor();
    });
});

test('a revoked browser shows the pairing screen, not an empty page', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.paired = false;
        await page.getByRole('heading', { name: 'Pair with boat' }).waitFor();
    });
});

test('leave forgets this browser', { timeout }, async () => {
    await withPage({ at: '#/boat/more' }, async ({ page }) => {
        await page.getByRole('button', { name: /Leave/ }).click();
        await page.getByRole('heading', { name: 'Pair with boat' }).waitFor();
    });
});

test('a script or the style that does not arrive leaves words', { timeout }, async () => {
    await withPage({ board: (b) => { b.brokenAsset = /\.js$/; } }, async ({ page }) => {
        await page.getByText('The page could not be loaded').waitFor();
        await page.waitForTimeout(500);
        assert.match(await page.locator('body').innerText(), /could not be loaded/);
    });
    await withPage({ board: (b) => { b.brokenAsset = /\.css$/; } }, async ({ page }) => {
        await page.getByText(/Without its style/).waitFor();
    });
});

test('a part that does not arrive is named, the rest works', { timeout }, async () => {
    const broken = (b) => { b.brokenAsset = /^part-/; };
    await withPage({ at: '#/boat/config', board: broken }, async ({ page }) => {
        await page.getByText('The editor did not arrive.').waitFor();
        await page.getByText('The same as what runs.').waitFor();
        await page.getByRole('link', { name: 'Timing' }).first().click();
        await page.getByText('The plot did not arrive.').first().waitFor();
        await page.getByRole('link', { name: 'Live' }).first().click();
        await waitLive(page);
    });
});

test('a server that is silent from the start leaves words', { timeout }, async () => {
    await withPage({ board: (b) => { b.dead = true; } }, async ({ page, board }) => {
        await page.getByText('Waiting for the board').waitFor();
        await page.getByText('The board did not answer for 5 s.').waitFor();
        board.dead = false;
        await waitLive(page);
    });
});
