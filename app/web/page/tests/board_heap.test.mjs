// The memory of a page that stays open, before the real server and the real daemon.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, waitLive, withBoard } from './browser.mjs';

const MINUTES = Number(process.env.TRIBUS_HEAP_MINUTES ?? 10);
/** The last ten minutes of figures, which the page keeps, are some 0.5 MB of it. */
const MOST_GROWTH = 1_500_000;

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = (MINUTES + 2) * 60_000;

test(`the memory is steady for ${MINUTES} minutes`, { timeout }, async () => {
    await withBoard(browser, {}, async ({ page, board }) => {
        await waitLive(page);
        board.sweep();
        const session = await page.context().newCDPSession(page);
        const heap = async () => {
            await session.send('HeapProfiler.collectGarbage');
            return (await session.send('Runtime.getHeapUsage')).usedSize;
        };
        await page.waitForTimeout(10_000);
        const sizes = [await heap()];
        for (let minute = 0; minute < MINUTES; ++minute) {
            await page.waitForTimeout(60_000);
            await waitLive(page);
            sizes.push(await heap());
        }
        console.log(`kB each minute: ${sizes.map((size) => Math.round(size / 1000)).join(' ')}`);
        assert.ok(sizes.at(-1) - sizes[0] < MOST_GROWTH, `grown by ${sizes.at(-1) - sizes[0]}`);
        const nodes = await page.evaluate(() => document.getElementsByTagName('*').length);
        assert.ok(nodes < 2000, `${nodes} elements`);
    });
});
