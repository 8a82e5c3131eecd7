// Daemon and server die and come again in every order: the page says what runs only while it knows.
import assert from 'node:assert/strict';
import { after, before, describe, test } from 'node:test';
import { openBrowser, waitLive, withBoard } from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 180_000;
/** The list of daemons is asked for each 5 s, an answer may take 5 s, and a stream opens in 3 s. */
const SETTLED = { timeout: 30_000 };

const EVENTS = {
    'the daemon dies': async (board) => { await board.stopDaemon(); },
    'the server dies': async (board) => { board.server.kill('SIGKILL'); },
    'the daemon comes': async (board) => { await board.runDaemon(); },
    'the server comes': async (board) => { await board.runServer(); },
};

/** All orders in which both die and both come again. */
function orders() {
    const merge = (one, other) => (one.length === 0 ? [other] : other.length === 0 ? [one] : [
        ...merge(one.slice(1), other).map((rest) => [one[0], ...rest]),
        ...merge(one, other.slice(1)).map((rest) => [other[0], ...rest]),
    ]);
    return merge(['the daemon dies', 'the daemon comes'], ['the server dies', 'the server comes']);
}

/** What the page says once it had the time to notice. */
async function expectTruth(page, { daemon, server }, step) {
    const absent = page.getByTestId('absent');
    const banner = page.getByTestId('stale');
    if (server && daemon) {
        await waitLive(page);
    } else if (server) {
        await absent.waitFor(SETTLED);
    } else {
        await absent.waitFor({ state: 'hidden', ...SETTLED });
        await banner.getByText(/cannot be reached|No news from the board/).waitFor(SETTLED);
        await banner.getByText(/ (old|ago)\b/).waitFor(SETTLED);
        // Also when it has waited for longer than any evidence lasts.
        await page.waitForTimeout(12_000);
        assert.equal(await absent.count(), 0, step);
        assert.match(await banner.innerText(), / (old|ago)\b/, step);
    }
}

async function walk(view, steps, up) {
    for (const step of steps) {
        await EVENTS[step](view.board);
        const [, who, what] = step.split(' ');
        up[who] = what === 'comes';
        await expectTruth(view.page, up, `${steps.join(', ')}: ${step}`);
    }
    view.problems.length = 0; // requests to a server that is dead
}

// They wait more than they compute.
describe('daemon and server die and come again', { concurrency: 3 }, () => {
    for (const steps of orders()) {
        test(steps.join(', '), { timeout }, async () => {
            await withBoard(browser, {}, async (view) => {
                await waitLive(view.page);
                await walk(view, steps, { daemon: true, server: true });
            });
        });
    }

    test('a page that never saw the daemon', { timeout }, async () => {
        await withBoard(browser, { runs: false }, async (view) => {
            await view.page.getByTestId('absent').waitFor(SETTLED);
            const steps = ['the server dies', 'the daemon comes', 'the server comes'];
            await walk(view, steps, { daemon: false, server: true });
        });
    });
});
