// Many tabs of one browser before the real server, by address and by name.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { until } from './board.mjs';
import {
    button, openBrowser, sees, trialOf, typeInto, waitLive, withBoard,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 120_000;
const HOSTS = ['127.0.0.1', 'board.local'];
/** As many as the server gives one browser (docs/web.md). */
const STREAMS = 4;
const reach = (host) => ({ host, words: ['--host', 'board.local'] });
const goOn = (page) => button(page, 'Go on here');

/** That many streams are open, and stay so. */
async function hasStreams(relay, count) {
    await until(() => relay.streams() === count, () => `${count} streams, of ${relay.streams()}`);
}

for (const host of HOSTS) {
    test(`eight tabs at ${host}: none hangs`, { timeout }, async () => {
        await withBoard(browser, reach(host), async ({ page, context, relay, address }) => {
            await waitLive(page);
            const tabs = [page];
            while (tabs.length < 8) {
                const tab = await context.newPage();
                tabs.push(tab);
                await tab.goto(address);
                await waitLive(tab);
            }
            const ended = tabs.slice(0, 8 - STREAMS);
            for (const tab of ended) {
                await sees(tab, 'another page of this browser took the place');
                await goOn(tab).waitFor();
            }
            for (const tab of tabs.slice(8 - STREAMS)) {
                assert.equal(await goOn(tab).count(), 0);
                await waitLive(tab);
            }
            await hasStreams(relay, STREAMS);
            // Each tab is answered while four streams are open.
            for (const tab of tabs) {
                const status = await tab.evaluate(async () => (await fetch('/api/me',
                    { signal: AbortSignal.timeout(5000) })).status);
                assert.equal(status, 200);
            }
            await goOn(tabs[0]).click();
            await waitLive(tabs[0]);
            await goOn(tabs[8 - STREAMS]).waitFor();
            await hasStreams(relay, STREAMS);
            // Nobody waits for a hidden page: its stream closes, and it shows nothing as live.
            const show = (tab, hidden) => tab.evaluate((value) => {
                Object.defineProperty(document, 'hidden',
                    { configurable: true, get: () => value });
                document.dispatchEvent(new Event('visibilitychange'));
            }, hidden);
            await show(tabs[7], true);
            await hasStreams(relay, STREAMS - 1);
            assert.equal(await tabs[7].locator('.frame').getAttribute('data-level'), 'stale');
            await show(tabs[7], false);
            await waitLive(tabs[7]);
            await hasStreams(relay, STREAMS);
        });
    });
}

test('by name, where the context is not secure, all of it works', { timeout }, async () => {
    await withBoard(browser, reach('board.local'), async ({ page, board }) => {
        await waitLive(page);
        assert.equal(await page.evaluate(() => isSecureContext), false);
        await page.getByRole('link', { name: 'Configuration' }).click();
        await typeInto(page, '\n[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n');
        await sees(page, /now channel 1, reverse/);
        await button(page, 'Try for 30 s').click();
        await board.servos('control 1900 1500 1500 1500');
        await button(page, 'Keep').click();
        await trialOf(page).getByText(/Kept/).waitFor();
        assert.match(await board.text(), /reverse = true/);
        const { screens } = await page.evaluate(async () => (await fetch('/api/me')).json());
        for (const screen of screens) {
            await page.goto(`${new URL(page.url()).origin}/#/boat/${screen}`);
            await page.locator('main h1').waitFor();
            await waitLive(page);
        }
        await page.getByRole('button', { name: /^Leave/ }).click();
        await page.getByRole('heading', { name: /^Pair with/ }).waitFor();
    });
});
