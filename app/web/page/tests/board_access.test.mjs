// Each screen in each state before the real daemon: axe, width, keyboard, motion, large text.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
    button, openBrowser, sees, tabTo, tooWide, trialOf, typeInto, violations, waitLive,
    withBoard,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 240_000;
const wait = (page, selector) => page.locator(selector).first().waitFor();

/** A screen by its address; the words in the bars differ with the width. */
const goTo = async (page, screen) => {
    await page.evaluate((to) => { location.hash = `#/boat/${to}`; }, screen);
    await page.waitForTimeout(300);
};

/** Brings the board from state to state, and names each. */
async function* configurationStates({ page, board }) {
    await goTo(page, 'config');
    await sees(page, 'The same as what runs.');
    yield 'configuration';
    await typeInto(page, 'nonsense = 1\n', 'Home');
    await wait(page, '.mistakes');
    yield 'configuration with a mistake';
    await button(page, 'Drop my changes').click();
    await typeInto(page, '# tried\n', 'Home');
    await sees(page, 'The same as what runs.');
    await button(page, 'Try for 30 s').click();
    await trialOf(page).getByText(/On trial/).waitFor();
    yield 'configuration on trial';
    await button(page, 'Back').click();
    await sees(page, 'The configuration before runs again.');
    yield 'configuration after a trial';
    await board.write(`# theirs\n${await board.text()}`);
    await button(page, 'Try for 30 s').click();
    await wait(page, '.conflict');
    yield 'configuration changed by another';
    await button(page, 'Take theirs, drop mine').click();
}

async function* otherScreens({ page }) {
    const { screens } = await page.evaluate(async () => (await fetch('/api/me')).json());
    for (const screen of screens) {
        if (!['live', 'config'].includes(screen)) {
            await goTo(page, screen);
            await page.waitForTimeout(500);
            yield screen;
        }
    }
}

async function* liveStates({ page, board, relay }) {
    await goTo(page, 'live');
    yield 'live';
    board.cutWire(true);
    await wait(page, '.sentence[data-state=failsafe]');
    yield 'failsafe';
    relay.cut();
    await wait(page, '.frame[data-level=stale]');
    yield 'stale';
    relay.mend();
    await waitLive(page);
    await board.runDaemon();
    await wait(page, '.sentence[data-state=waiting]');
    yield 'never seen';
    await board.stopDaemon();
    await page.getByTestId('absent').waitFor();
    yield 'absent';
}

async function* states(view) {
    yield* configurationStates(view);
    yield* otherScreens(view);
    yield* liveStates(view);
    await view.board.pairing('--revoke', 'browser');
    await view.page.getByRole('heading', { name: /^Pair with/ }).waitFor();
    yield 'pair';
}

for (const [scheme, width] of [['dark', 360], ['light', 360], ['dark', 1280], ['light', 1280]]) {
    test(`axe, ${scheme}, ${width} px`, { timeout }, async () => {
        const height = width === 360 ? 740 : 900;
        const map = '[pipeline.main.failsafe]\nhold = "0s"\n';
        await withBoard(browser, { scheme, width, height, map }, async (view) => {
            await waitLive(view.page);
            const found = [];
            for await (const name of states(view)) {
                const wide = await tooWide(view.page);
                found.push(...(await violations(view.page)).map((one) => `${name}: ${one}`),
                    ...(wide > 0 ? [`${name}: ${wide} px too wide`] : []));
            }
            assert.deepEqual(found, []);
        });
    });
}

test('who may only look sees why, also to axe', { timeout }, async () => {
    const options = { pairs: ['--look'], at: '#/boat/config' };
    await withBoard(browser, options, async ({ page }) => {
        await sees(page, 'This browser may only look.');
        assert.equal(await button(page, 'Try for 30 s').count(), 0);
        assert.deepEqual(await violations(page), []);
    });
});

test('text at 200 % does not break a screen', { timeout }, async () => {
    const map = '[pipeline.main.failsafe]\nhold = "0s"\n';
    await withBoard(browser, { width: 360, height: 740, map }, async (view) => {
        await waitLive(view.page);
        await view.page.evaluate(() => { document.documentElement.style.fontSize = '200%'; });
        for await (const name of states(view)) {
            assert.ok(await tooWide(view.page) <= 0, `${name} is too wide`);
        }
    });
});

test('by keyboard alone: pair, edit, try, keep', { timeout }, async () => {
    await withBoard(browser, { pairs: false }, async ({ page, board }) => {
        await page.getByRole('heading', { name: /^Pair with/ }).waitFor();
        const code = await board.code();
        await page.keyboard.press('Tab');
        await page.keyboard.type(code);
        await page.keyboard.press('Enter');
        await waitLive(page);
        await tabTo(page, 'Configuration');
        const outline = await page.evaluate(() =>
            getComputedStyle(document.activeElement).outlineStyle);
        assert.equal(outline, 'solid', 'the focus is visible');
        await page.keyboard.press('Enter');
        await wait(page, '.cm-content');
        await sees(page, 'The same as what runs.');
        await tabTo(page, 'Configuration [input');
        await page.keyboard.press('Control+End');
        await page.keyboard.type('[pipeline.main.channels]');
        await page.keyboard.press('Enter');
        await page.keyboard.insertText('1 = { from = 1, reverse = true }');
        await sees(page, /now channel 1, reverse/);
        await tabTo(page, 'Try for 30 s');
        await page.keyboard.press('Enter');
        await trialOf(page).getByText(/On trial/).waitFor();
        await board.servos('control 1900 1500 1500 1500');
        await tabTo(page, 'Keep');
        await page.keyboard.press('Space');
        await trialOf(page).getByText(/Kept/).waitFor();
        assert.match(await board.text(), /reverse = true/);
    });
});

test('with reduced motion nothing moves by itself', { timeout }, async () => {
    await withBoard(browser, { reducedMotion: 'reduce' }, async (view) => {
        const { page, board } = view;
        await waitLive(page);
        board.sweep();
        for await (const name of states(view)) {
            const moves = await page.evaluate(() => [
                document.getAnimations().length,
                ...[...document.querySelectorAll('*')].map((e) =>
                    parseFloat(getComputedStyle(e).transitionDuration)),
            ].reduce((sum, one) => sum + one));
            assert.equal(moves, 0, name);
        }
    });
});
