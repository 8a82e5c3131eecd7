// The page in front of the real server and the real daemon.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { openBrowser, waitLive } from './browser.mjs';
import { startBoard } from './board.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 90_000;

/** A page that was paired by typing the code. */
async function withBoard(options, body) {
    const board = await startBoard(options);
    const context = await browser.newContext({ viewport: { width: 1280, height: 900 } });
    context.setDefaultTimeout(15_000);
    const page = await context.newPage();
    const problems = [];
    page.on('pageerror', (error) => problems.push(String(error)));
    const foreign = [];
    page.on('request', (request) => {
        if (!request.url().startsWith(board.address) && !request.url().startsWith('data:')) {
            foreign.push(request.url());
        }
    });
    try {
        await page.goto(board.address, { timeout: 15_000 });
        await page.getByLabel('Code', { exact: true }).fill(await board.code());
        await page.getByRole('button', { name: 'Pair' }).click();
        await waitLive(page);
        await body({ page, board, context });
        assert.deepEqual(problems, []);
        assert.deepEqual(foreign, [], 'a request left the origin');
    } finally {
        await context.close();
        await board.close();
    }
}

const sees = (page, text) => page.getByText(text).first().waitFor();

test('sticks move before and after; a reversed channel is seen', { timeout }, async () => {
    const map = '[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n';
    await withBoard({ map }, async ({ page, board }) => {
        await sees(page, 'under control of receiver');
        await sees(page, /^1100$/);
        await sees(page, /^1900$/);
        board.setPulses([1234]);
        await sees(page, /^1234$/);
        await sees(page, /^1766$/);
    });
});

test('a cut wire is failsafe with its cause, and control comes back', { timeout }, async () => {
    await withBoard({}, async ({ page, board }) => {
        await sees(page, 'under control of receiver');
        board.cutWire(true);
        // A locator looks twice a second only; this looks with each picture.
        await page.waitForFunction(() => /wire silent/.test(document.body.innerText)
            && /failsafe/.test(document.body.innerText), null, { polling: 'raf' });
        const shown = performance.now();
        // The log looks five times a second and may come later than the page.
        const logged = await board.logged(/servos: in failsafe/);
        console.log(`failsafe on the page ${Math.round(shown - logged)} ms after the log`);
        board.cutWire(false);
        await sees(page, 'under control of receiver');
    });
});

test('a daemon or a server that hangs is never shown as live', { timeout }, async () => {
    await withBoard({}, async ({ page, board }) => {
        for (const child of [board.daemon, board.server]) {
            child.kill('SIGSTOP');
            await page.locator('.lamp.live').waitFor({ state: 'detached' });
            await page.getByTestId('stale').waitFor();
            child.kill('SIGCONT');
            await waitLive(page);
        }
    });
});

test('a draft is tried, seen on the servos, and kept', { timeout }, async () => {
    await withBoard({}, async ({ page, board }) => {
        const before = await board.text();
        await page.getByRole('link', { name: 'Configuration' }).click();
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+End');
        await page.keyboard.insertText('\n[pipeline.main.channels]\n1 = { from = 1, revers = true }\n');
        await sees(page, /revers/);
        const tryIt = page.getByRole('button', { name: 'Try for 30 s', exact: true });
        await page.locator('.cm-lintRange-error').first().waitFor();
        assert.equal(await tryIt.isDisabled(), true);
        await page.keyboard.press('ArrowUp');
        await page.keyboard.press('End');
        for (let i = 0; i < ' = true }'.length; ++i) {
            await page.keyboard.press('ArrowLeft');
        }
        await page.keyboard.insertText('e');
        await sees(page, /channel 1: channel 1 before, now channel 1, reverse/);
        await tryIt.click();
        await page.getByTestId('trial').getByText(/On trial: \d+ s left/).waitFor();
        assert.equal(await board.text(), before);
        await page.getByRole('link', { name: 'Live' }).first().click();
        await sees(page, /^1900$/);
        await page.getByRole('button', { name: 'Keep', exact: true }).click();
        await page.getByTestId('trial').getByText(/Kept/).waitFor();
        assert.match(await board.text(), /reverse = true/);
    });
});

test('a trial whose tab closes goes back by itself', { timeout }, async () => {
    await withBoard({}, async ({ page, board, context }) => {
        await page.getByRole('link', { name: 'Configuration' }).click();
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+End');
        await page.keyboard.insertText('\n[pipeline.main.channels]\n1 = { from = 1, reverse = true }\n');
        await page.getByRole('button', { name: 'Try for 30 s', exact: true }).click();
        await page.getByTestId('trial').getByText(/On trial/).waitFor();
        await page.close();
        const again = await context.newPage();
        await again.goto(board.address);
        await again.getByText(/^1900$/).first().waitFor();
        await again.getByText(/^1100$/).nth(1).waitFor({ timeout: 45_000 });
        assert.match(board.log.text, /going back to the configuration before/);
    });
});
