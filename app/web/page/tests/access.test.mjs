// Every screen without axe violations, and all of it by keyboard.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
    openBrowser, openPage, tabTo, tooWide, violations, waitLive,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 300_000;

const wait = (selector) => (page) => page.locator(selector).first().waitFor();
const mistake = async (page) => {
    await page.locator('.cm-content').click();
    await page.keyboard.insertText('nonsense\n');
    await page.locator('.mistakes').waitFor();
};
const SCREENS = [
    ['live', '#/boat/live', {}],
    ['live in failsafe', '#/boat/live', { scene: 'failsafe' }],
    ['live while held', '#/boat/live', { scene: 'hold' }],
    ['live never seen', '#/boat/live', { scene: 'never_seen' }],
    ['live rover', '#/rover/live', {}],
    ['live absent', '#/spare/live', { live: false }],
    ['live stale', '#/rover/live', { then: async (page, board) => {
        board.sends = false;
        await wait('.frame[data-level=stale]')(page);
    } }],
    ['public', '#/boat/live', { public: true }],
    ['pair', '', { paired: false, live: false }],
    ['config', '#/boat/config', { then: wait('.diff, .verdict .quiet') }],
    ['config with a mistake', '#/boat/config', { then: mistake }],
    ['config on trial', '#/boat/config', { then: async (page) => {
        await page.locator('.cm-content').click();
        await page.keyboard.insertText('# x\n');
        await page.getByRole('button', { name: 'Try for 30 s' }).click();
        await wait('.trial')(page);
    } }],
    ['config merge', '#/boat/config', { then: async (page, board) => {
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+Home');
        await page.keyboard.insertText('# x\n');
        board.changeByAnother('boat', `# y\n${board.fileOf('boat').text}`);
        await page.getByRole('button', { name: 'Try for 30 s' }).click();
        await wait('.conflict')(page);
    } }],
    ['config look', '#/boat/config', { role: 'look', then: wait('.cm-content') }],
    ['timing', '#/rover/timing', { then: wait('.plot canvas') }],
    ['doctor', '#/boat/doctor', { then: wait('.finding') }],
    ['learn', '#/boat/learn', { then: async (page) => {
        await page.getByRole('button', { name: 'Start' }).click();
        await wait('.order')(page);
    } }],
    ['recordings', '#/boat/recordings', { then: async (page) => {
        await page.getByRole('button', { name: /^Plot/ }).first().click();
        await wait('.plot canvas')(page);
    } }],
    ['more', '#/boat/more', {}],
];

for (const [scheme, width] of [['dark', 360], ['light', 360], ['dark', 1280], ['light', 1280]]) {
    test(`axe, ${scheme}, ${width} px`, { timeout }, async () => {
        const found = [];
        for (const [name, at, options] of SCREENS) {
            const view = await openPage(browser, { at, scheme, width, board: (b) => {
                b.paired = options.paired ?? true;
                b.role = options.role ?? 'change';
                b.public = options.public ?? false;
                b.scenes.boat = options.scene ?? 'good';
            } });
            try {
                await (options.live === false
                    ? wait('h1')(view.page) : waitLive(view.page));
                await options.then?.(view.page, view.board);
                found.push(...[...await violations(view.page), ...view.problems]
                    .map((one) => `${name}: ${one}`));
                const wide = await tooWide(view.page);
                if (wide > 0) {
                    found.push(`${name}: ${wide} px too wide`);
                }
            } finally {
                await view.close();
            }
        }
        assert.deepEqual(found, []);
    });
}

test('text at 200 % does not break the screens', { timeout }, async () => {
    for (const at of ['#/boat/live', '#/boat/config', '#/boat/timing', '#/boat/more']) {
        const view = await openPage(browser, { at, width: 360 });
        await waitLive(view.page);
        await view.page.evaluate(() => { document.documentElement.style.fontSize = '200%'; });
        await view.page.waitForTimeout(400);
        const wide = await tooWide(view.page);
        assert.ok(wide <= 0, `${at}: ${wide} px too wide`);
        await view.close();
    }
});

test('an edit, a trial and back by keyboard alone', { timeout }, async () => {
    const view = await openPage(browser, {});
    const { page, board } = view;
    try {
        await waitLive(page);
        await tabTo(page, 'Configuration');
        const outline = await page.evaluate(() =>
            getComputedStyle(document.activeElement).outlineStyle);
        assert.equal(outline, 'solid', 'the focus is visible');
        await page.keyboard.press('Enter');
        await page.locator('.cm-content').waitFor();
        await tabTo(page, 'Configuration # The boat');
        await page.keyboard.type('# by keyboard');
        await page.keyboard.press('Enter');
        await page.getByText('What changes').waitFor();
        await tabTo(page, 'Try for 30 s');
        await page.keyboard.press('Enter');
        await page.getByTestId('trial').waitFor();
        await tabTo(page, 'Keep');
        await page.keyboard.press('Tab');
        await page.keyboard.press('Space');
        await page.getByText('The configuration before runs again.').waitFor();
        assert.equal(board.trialOf('boat'), null);
    } finally {
        await view.close();
    }
});
