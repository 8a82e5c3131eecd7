// The Live screen: every state is drawn in words, and nothing old looks live.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
    lampText, looksLive, openBrowser, openPage, waitLive, whenItAges, withPage as withMock,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 60_000;

const withPage = (options, body) => withMock(browser, options, body);

const said = (page) => page.locator('.sentence .said').first().innerText();
const why = (page) => page.locator('.sentence .why').first().innerText();

const CAUSES = ['garbled', 'stale', 'implausible', 'channels_missing', 'no_key', 'forged', 'replayed',
    'late'];
const WORDS = [
    ['good', 'control', /^under control of receiver$/, /^$/],
    ['never_seen', 'waiting', /^waiting: in failsafe$/, /receiver: never seen/],
    ['hold', 'hold', /^holding the last values$/,
        /^failsafe in 180 ms; waits for receiver: wire silent \(as the daemon says\)/],
    ['failsafe', 'failsafe', /^in failsafe$/,
        /presets; waits for receiver: radio lost \(as the daemon says\) for 4.2 s/],
    ['forced', 'failsafe', /^in failsafe, forced$/, /GPIO line/],
    ['awaits_release', 'failsafe', /^in failsafe until release_when is true$/, /presets/],
    ['silent', 'silent', /^in failsafe$/, /it sends nothing/],
    ['unproved', 'failsafe', /^in failsafe$/, /waits for receiver: good for 0.2 of 0.5 s$/],
    ['cannot_send_device', 'cannot_send', /^cannot send: its device is gone$/, /.*/],
    ['cannot_send_bus', 'cannot_send', /^cannot send: the bus takes nothing$/, /.*/],
    ...CAUSES.map((cause) => [cause, 'failsafe', /^in failsafe$/,
        new RegExp(`receiver: ${cause.replaceAll('_', ' ')} \\(as the daemon says\\) for 4.2 s`)]),
];

test('each state and cause stands in the words of the daemon', { timeout }, async () => {
    await withPage({ at: '#/boat/live' }, async ({ page, board }) => {
        await waitLive(page);
        for (const [scene, state, sentence, reason] of WORDS) {
            board.scenes.boat = scene;
            await page.locator(`.sentence[data-state=${state}]`).waitFor();
            await page.waitForTimeout(350);
            assert.match(await said(page), sentence, scene);
            assert.match(await why(page), reason, scene);
        }
    });
});

test('channels of an input that no output can use yet are shown, not struck out', { timeout },
    async () => {
        await withPage({ board: (b) => { b.scenes.boat = 'unproved'; } }, async ({ page }) => {
            await waitLive(page);
            await page.locator('td.scale .bar.ignored').first().waitFor();
            assert.equal(await page.locator('td.us s').count(), 0);
        });
    });

test('failsafe is a pattern and a word, not only a colour', { timeout }, async () => {
    await withPage({ board: (b) => { b.scenes.boat = 'failsafe'; } }, async ({ page }) => {
        await waitLive(page);
        const bar = page.locator('td.scale .bar.preset').first();
        await bar.waitFor();
        assert.equal(await bar.locator('.label').innerText(), 'preset');
        const image = await bar.locator('.fill')
            .evaluate((e) => getComputedStyle(e).backgroundImage);
        assert.match(image, /repeating-linear-gradient/);
    });
});

test('a reversed channel moves the other way', { timeout }, async () => {
    await withPage({ board: (b) => { b.scenes.boat = 'reversed'; } }, async ({ page }) => {
        await waitLive(page);
        const row = page.locator('table[data-pair=servos] tbody tr').nth(1);
        await page.waitForTimeout(400);
        assert.deepEqual(await row.locator('td.us').allInnerTexts(), ['1830', '1170']);
        const moves = await row.locator('.fill')
            .evaluateAll((all) => all.map((e) => e.style.transform));
        assert.deepEqual(moves, ['translateX(-26.43%)', 'translateX(-73.57%)']);
    });
});

test('outvoted inputs and broken buses are named', { timeout }, async () => {
    await withPage({ at: '#/rover/live' }, async ({ page }) => {
        await waitLive(page);
        assert.match(await why(page), /tail: outvoted by the others/);
        const list = await page.getByTestId('attention').innerText();
        for (const text of ['CAN can1: bus-off: the controller left', 'GPIO lamp: is gone; waiting',
            'motor_temperature: stale: 61.4 degC, 12.4 s old', 'memory is not locked']) {
            assert.ok(list.includes(text), text);
        }
        assert.match(await page.locator('.facts').innerText(), /controls servos/);
    });
});

test('silence: grey at 0.5 s, banner at 1 s, nothing looks live', { timeout }, async () => {
    await withPage({ at: '#/rover/live' }, async ({ page, board }) => {
        await waitLive(page);
        const times = page.evaluate(whenItAges);
        board.sends = false;
        const { late, stale } = await times;
        // Earlier by what the last status was late; never later.
        assert.ok(late > 250 && late < 700, `grey after ${late} ms`);
        assert.ok(stale > 750 && stale < 1200, `banner after ${stale} ms`);
        assert.match(await page.getByTestId('stale').innerText(),
            /No news from the board.*1\.\d s old/s);
        assert.deepEqual(await looksLive(page), []);
        assert.match(await said(page), /^Last known:/);
        assert.ok(!/live/.test(await lampText(page)));
        const first = await page.getByTestId('stale').innerText();
        await page.waitForTimeout(400);
        assert.notEqual(await page.getByTestId('stale').innerText(), first, 'the age runs');
    });
});

test('a silent server: a new connection after 3 s, live again', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.sends = false;
        board.requests.length = 0;
        await page.waitForTimeout(3700);
        const again = board.requests.filter((one) => one.endsWith('/stream')).length;
        assert.equal(again, 1);
        assert.equal(board.streams.size, 1, 'the old stream is closed');
        board.sends = true;
        await waitLive(page);
        assert.deepEqual(await page.getByTestId('stale').isVisible(), false);
    });
});

test('the daemon is gone: the page says so and why', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.gone = 'it was stopped';
        await page.getByText('The daemon is gone: it was stopped.').waitFor();
        assert.deepEqual(await looksLive(page), []);
        board.gone = null;
        await waitLive(page);
    });
});

test('the data thread hangs: old figures that come in time are old', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.extra = { figures_age_us: 700_000 };
        await page.locator('.frame[data-level=late]').waitFor();
        board.extra = { figures_age_us: 4_200_000 };
        await page.getByText(/data thread hangs: it has published nothing for 4\.\d s/).waitFor();
        assert.deepEqual(await looksLive(page), []);
    });
});

test('figures that never came are as old as the daemon', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.extra = { figures_age_us: null, uptime_us: 5_200_000 };
        await page.getByText(/data thread hangs: it has published nothing for 5\.\d s/).waitFor();
        assert.deepEqual(await looksLive(page), []);
    });
});

test('a status that was long under way is old', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        await page.waitForTimeout(500);
        const behind = setInterval(() => {
            board.extra = { t_us: Math.round((performance.now() - 1800) * 1000) };
        }, 5);
        // The board's clock must not seem to go back.
        board.sends = false;
        await page.waitForTimeout(1900);
        board.sends = true;
        await page.getByText(/The network is slow: what arrives is \d/).waitFor();
        clearInterval(behind);
    });
});

test('a hidden page closes its stream, a visible one opens it', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        const show = (hidden) => page.evaluate((value) => {
            Object.defineProperty(document, 'hidden', { configurable: true, get: () => value });
            document.dispatchEvent(new Event('visibilitychange'));
        }, hidden);
        await show(true);
        await page.waitForTimeout(300);
        assert.equal(board.streams.size, 0);
        assert.equal(await page.locator('.frame').getAttribute('data-level'), 'stale');
        await show(false);
        await waitLive(page);
        assert.equal(board.streams.size, 1);
    });
});

test('an absent daemon: no values, a way to its configuration', { timeout }, async () => {
    await withPage({ at: '#/spare/live' }, async ({ page }) => {
        await page.getByTestId('absent').waitFor();
        assert.equal(await page.locator('td.us').count(), 0);
        assert.equal(await lampText(page), 'no daemon');
        await page.getByRole('link', { name: 'Open the configuration' }).waitFor();
    });
});

test('a fifth page takes the place: this one offers to go on', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        for (const stream of board.streams) {
            stream.write('event: ended\ndata: {"reason":"a fifth page was opened"}\n\n');
            stream.end();
        }
        await page.getByText('a fifth page was opened').waitFor();
        await page.waitForTimeout(3500);
        assert.equal(board.streams.size, 0);
        await page.getByRole('button', { name: 'Go on here' }).click();
        await waitLive(page);
    });
});

test('a status without some lists is shown all the same', { timeout }, async () => {
    const options = { board: (b) => { b.extra = { values: undefined, ports: undefined }; } };
    await withPage(options, async ({ page }) => {
        await waitLive(page);
        assert.match(await said(page), /under control of receiver/);
    });
});

test('a status that cannot be shown leaves words, not old values', { timeout }, async () => {
    const view = await openPage(browser, {});
    try {
        await waitLive(view.page);
        view.board.extra = { outputs: null };
        await view.page.getByText('its status cannot be shown').waitFor();
        assert.deepEqual(await looksLive(view.page), []);
        view.board.extra = { values: [null] };
        await view.page.getByText('This page failed').waitFor();
        assert.equal(await view.page.locator('td.us').count(), 0);
    } finally {
        await view.close();
    }
});
