// Timing, Doctor, Learn, Recordings, and what concerns all screens.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { button, openBrowser, waitLive, withPage as withMock } from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 60_000;

const withPage = (options, body) => withMock(browser, options, body);

test('timing: causes are stripes with words, plots come when needed', { timeout }, async () => {
    await withPage({ at: '#/boat/live' }, async ({ page, board }) => {
        await waitLive(page);
        const parts = () => board.requests.filter((one) => one.includes('/part-')).length;
        assert.equal(parts(), 0, 'no heavy part before it is needed');
        board.scenes.boat = 'radio_lost';
        await page.locator('.sentence[data-state=failsafe]').waitFor();
        await page.waitForTimeout(1200);
        board.scenes.boat = 'good';
        await page.getByRole('link', { name: 'Timing' }).first().click();
        await page.locator('.plot canvas').first().waitFor();
        assert.equal(parts(), 1);
        await page.getByText(/radio lost for 1\.\d s, until/).waitFor();
        await page.getByText(/failsafe for 1\.\d s, until/).waitFor();
        assert.ok(await page.locator('.stripe .bad').count() >= 2);
    });
});

test('timing: distributions are bars with words, of the last minute or of all', { timeout }, async () => {
    await withPage({ at: '#/boat/timing' }, async ({ page }) => {
        await waitLive(page);
        const latency = page.getByRole('img', { name: /^Latency of servos\. \d+ frames, most from/ });
        await latency.waitFor();
        assert.ok(await latency.locator('rect').count() > 5);
        const before = await latency.getAttribute('aria-label');
        await page.getByLabel('Frames of').selectOption('all since the start');
        await page.waitForFunction((old) => ![...document.querySelectorAll('.histogram svg')]
            .some((one) => one.getAttribute('aria-label') === old), before);
    });
});

test('timing: what changed while the page heard nothing is told afterwards', { timeout }, async () => {
    await withPage({ at: '#/boat/timing' }, async ({ page, board }) => {
        await waitLive(page);
        await page.locator('.stripes').waitFor();
        assert.equal(await page.locator('.stripe').first().locator('span').count(), 1);
        board.sends = false;
        await page.waitForTimeout(1500);
        board.scenes.boat = 'radio_lost';
        board.status('boat');
        await page.waitForTimeout(1200);
        board.scenes.boat = 'good';
        board.status('boat');
        board.sends = true;
        await waitLive(page);
        await page.getByText(/radio lost for 1\.[2-9] s, until/).waitFor();
        assert.equal(await page.locator('.stripe').first().locator('span').count(), 3);
    });
});

test('doctor: findings with their cure; it listens on a free port', { timeout }, async () => {
    await withPage({ at: '#/boat/doctor' }, async ({ page }) => {
        await page.getByText('problem: /dev/ttyAMA0: a login runs on it').waitFor();
        await page.getByText('sudo systemctl disable --now serial-getty@ttyAMA0').waitFor();
        await page.getByText('In use by tribus@boat.').waitFor();
        await button(page, 'Listen 3 s on /dev/ttyAMA4').click();
        await page.getByText('Heard i.Bus: 390 frames, 14 channels.').waitFor();
        await page.getByText('spi      = "/dev/spidev0.0"').waitFor();
    });
});

test('learn: step by step, the lines go into the draft', { timeout }, async () => {
    await withPage({ at: '#/boat/learn' }, async ({ page }) => {
        await waitLive(page);
        await page.getByText('Take the propellers off first').waitFor();
        await button(page, 'Start').click();
        await button(page, 'Sticks moved, hands off').click();
        await page.getByText('Off now', { exact: true }).waitFor();
        await button(page, 'The transmitter is off').click();
        await page.getByText('On now', { exact: true }).waitFor();
        await button(page, 'The transmitter is on and connected').click();
        await page.getByText('Recognised', { exact: true }).waitFor();
        await button(page, 'Put the lines into the draft').click();
        await page.locator('.cm-content').waitFor();
        assert.match(await page.locator('.cm-content').innerText(),
            /timeout {2}= "100ms"\nfailsafe_when = \[{ channel = 3, below = 945 }\]/);
    });
});

test('learn: broken off', { timeout }, async () => {
    await withPage({ at: '#/boat/learn' }, async ({ page }) => {
        await waitLive(page);
        await button(page, 'Start').click();
        await button(page, 'Stop').click();
        await page.getByText('Broken off').waitFor();
        await button(page, 'Once more').waitFor();
    });
});

test('recordings: list, record now, plot, download; no recorder', { timeout }, async () => {
    await withPage({ at: '#/boat/recordings' }, async ({ page, board }) => {
        await waitLive(page);
        await page.getByText('124 kB').waitFor();
        await button(page, 'Record now').click();
        await page.getByText('Written to /var/lib/tribus/boat/').waitFor();
        await button(page, 'Plot 2026-11-23T23-23-27Z-failsafe').click();
        await page.getByText('servos: hold from 25.1 s to 25.4 s').waitFor();
        await page.getByText('servos: not known from 0.0 s to 0.6 s').waitFor();
        await page.getByText('0.0 s to 32.0 s of 32.0 s').waitFor();
        board.busyPlots = 2;
        await button(page, 'Closer').click();
        await page.getByText('8.0 s to 24.0 s of 32.0 s').waitFor();
        await button(page, 'Later').click();
        await page.getByText('16.0 s to 32.0 s of 32.0 s').waitFor();
        assert.equal(await page.getByRole('link', { name: /^Download/ }).first()
            .getAttribute('href'), '/api/boat/recordings/2026-11-23T23-23-27Z-failsafe.tar');
        board.recorder = false;
        await page.reload();
        await page.getByText('There is no recorder.').waitFor();
    });
});

test('light, dark, as the system', { timeout }, async () => {
    await withPage({ scheme: 'dark' }, async ({ page }) => {
        await waitLive(page);
        const back = () => page.evaluate(() =>
            getComputedStyle(document.documentElement).backgroundColor);
        assert.equal(await back(), 'rgb(16, 19, 21)');
        await button(page, 'Colours: system. Change to light').click();
        assert.equal(await back(), 'rgb(255, 255, 255)');
        await page.reload();
        assert.equal(await back(), 'rgb(255, 255, 255)');
    });
});

test('another daemon: nothing of the one before stays', { timeout }, async () => {
    await withPage({ at: '#/boat/live' }, async ({ page, board }) => {
        await waitLive(page);
        board.sends = false;
        await page.getByLabel('Daemon').selectOption('rover');
        await page.getByText('No status has come yet.').waitFor();
        assert.equal(await page.locator('td.us').count(), 0);
        board.sends = true;
        await page.getByText('under control of left').first().waitFor();
        await waitLive(page);
        assert.equal(board.streams.size, 1);
    });
});

test('an unencrypted page says so on each screen', { timeout }, async () => {
    await withPage({ board: (b) => { b.public = true; } }, async ({ page }) => {
        await waitLive(page);
        for (const name of ['Timing', 'Configuration', 'Doctor']) {
            await page.getByRole('link', { name }).first().click();
            await page.getByText('Nothing is encrypted').waitFor();
        }
    });
});

test('no request leaves the origin', { timeout }, async () => {
    await withPage({}, async ({ page }) => {
        const foreign = [];
        const own = new URL(page.url()).origin;
        page.on('request', (request) => {
            if (!request.url().startsWith(own) && !request.url().startsWith('data:')) {
                foreign.push(request.url());
            }
        });
        for (const name of ['Timing', 'Configuration', 'Doctor', 'Learn', 'Recordings', 'More']) {
            await page.getByRole('link', { name, exact: true }).first().click();
            await page.waitForTimeout(300);
        }
        assert.deepEqual(foreign, []);
    });
});
