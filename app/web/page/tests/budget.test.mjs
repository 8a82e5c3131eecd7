// How fast the page is on a slow phone, and what it costs there.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, openPage, waitLive } from './browser.mjs';

const FIRST_PAINT_MS = 1000;
const FIRST_VALUE_MS = 1500;
const WORK_SHARE = 0.10;

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

/** A processor four times slower, 1.6 Mbit/s and 150 ms. */
async function slow(page) {
    const session = await page.context().newCDPSession(page);
    await session.send('Emulation.setCPUThrottlingRate', { rate: 4 });
    await session.send('Network.enable');
    await session.send('Network.emulateNetworkConditions', {
        offline: false, latency: 150, downloadThroughput: 200_000, uploadThroughput: 200_000,
    });
    await session.send('Performance.enable');
    return session;
}

async function metric(session, name) {
    const { metrics } = await session.send('Performance.getMetrics');
    return metrics.find((one) => one.name === name).value;
}

test('first paint and first live value', { timeout: 60_000 }, async () => {
    const view = await openPage(browser, { width: 360 });
    const { page } = view;
    await slow(page);
    await page.addInitScript(() => {
        const timer = setInterval(() => {
            if (document.querySelector('.lamp.live') && document.querySelector('td.us .value')) {
                globalThis.firstValue = performance.now();
                clearInterval(timer);
            }
        }, 10);
    });
    await page.reload({ waitUntil: 'commit' });
    await waitLive(page);
    await page.waitForFunction(() => globalThis.firstValue !== undefined);
    const [paint, value] = await page.evaluate(() => [
        performance.getEntriesByName('first-contentful-paint')[0].startTime,
        globalThis.firstValue,
    ]);
    await view.close();
    console.log(`first paint ${Math.round(paint)} ms, first live value ${Math.round(value)} ms`);
    assert.ok(paint < FIRST_PAINT_MS, `first paint ${paint} ms`);
    assert.ok(value < FIRST_VALUE_MS, `first live value ${value} ms`);
});

test('work of the page while ten statuses a second come', { timeout: 60_000 }, async () => {
    const view = await openPage(browser, { at: '#/rover/live', width: 360 });
    const { page } = view;
    const session = await slow(page);
    await waitLive(page);
    await page.waitForTimeout(2000);
    const before = await metric(session, 'ScriptDuration');
    const allBefore = await metric(session, 'TaskDuration');
    await page.waitForTimeout(6000);
    const script = (await metric(session, 'ScriptDuration') - before) / 6;
    const all = (await metric(session, 'TaskDuration') - allBefore) / 6;
    await view.close();
    console.log(`script ${(script * 100).toFixed(1)} %, with layout and paint `
        + `${(all * 100).toFixed(1)} % of a slowed core`);
    assert.ok(script < WORK_SHARE, `script ${script}`);
});

test('the memory does not grow while the page is open', { timeout: 90_000 }, async () => {
    const view = await openPage(browser, { at: '#/rover/live' });
    const { page } = view;
    const session = await page.context().newCDPSession(page);
    await session.send('HeapProfiler.enable');
    await waitLive(page);
    const heap = async () => {
        await session.send('HeapProfiler.collectGarbage');
        return page.evaluate(() => performance.memory.usedJSHeapSize);
    };
    await page.waitForTimeout(3000);
    const first = await heap();
    await page.waitForTimeout(20_000);
    const grown = await heap() - first;
    await view.close();
    console.log(`grown by ${Math.round(grown / 1000)} kB in 20 s`);
    assert.ok(grown < 1_000_000, `${grown} bytes in 20 s`);
});
