// A trial that nobody keeps, before the real daemon: it goes back in time, and the page says so.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import {
    button, openBrowser, sees, trialOf, typeInto, waitLive, withBoard,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 120_000;
const TRIAL_MS = 30_000;
const AT = '#/boat/config';
const OLD = 'control 1100 1500 1500 1500';
const NEW = 'control 1900 1500 1500 1500';

async function begin({ page, board }) {
    await sees(page, 'The same as what runs.');
    await typeInto(page, '\n[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n');
    await sees(page, /now channel 1, reverse/);
    await button(page, 'Try for 30 s').click();
    await board.servos(NEW);
    const began = performance.now();
    await trialOf(page).getByText(/On trial: \d+ s left/).waitFor();
    return began;
}

/** Waits until the servos have the old channel again, and says that this was in time. */
async function goesBack(board, began) {
    await board.servos(OLD, TRIAL_MS + 10_000);
    const took = performance.now() - began;
    console.log(`back after ${Math.round(took)} ms`);
    assert.ok(took > TRIAL_MS - 2000 && took < TRIAL_MS + 3000, `back after ${took} ms`);
    assert.match(board.log.text, /going back to the configuration before/);
}

// They wait more than they compute.
describe('a trial that nobody keeps', { concurrency: true }, () => {
    test('the tab is closed: another tab sees the end', { timeout }, async () => {
        await withBoard(browser, { at: AT }, async (view) => {
            const before = await view.board.text();
            const began = await begin(view);
            await view.page.close();
            const again = await view.context.newPage();
            await again.goto(`${view.address}#/boat/live`);
            await waitLive(again);
            await trialOf(again).getByText(/On trial, started elsewhere: \d+ s left/).waitFor();
            await goesBack(view.board, began);
            await trialOf(again).getByText(/The trial is over/).waitFor();
            await again.getByText(/^1100$/).nth(1).waitFor();
            assert.equal(await view.board.text(), before);
        });
    });

    test('the network is cut: the page counts itself, then hears it', { timeout }, async () => {
        await withBoard(browser, { at: AT }, async (view) => {
            const { page, board, relay } = view;
            const before = await board.text();
            const began = await begin(view);
            relay.cut();
            await trialOf(page).getByText('By this page\'s clock').waitFor();
            await goesBack(board, began);
            assert.equal(await trialOf(page).getByText('Kept').count(), 0);
            relay.mend();
            await trialOf(page).getByText(
                'The trial is over: the board went back to the configuration before.')
                .waitFor({ timeout: 30_000 });
            await waitLive(page);
            assert.equal(await board.text(), before);
        });
    });

    test('the server is killed: the daemon goes back all the same', { timeout }, async () => {
        await withBoard(browser, { at: AT }, async (view) => {
            const { page, board } = view;
            const began = await begin(view);
            board.server.kill('SIGKILL');
            await page.getByTestId('stale').waitFor();
            await goesBack(board, began);
        });
    });
});
