// The Configuration screen: mistakes, trial, keep, back, a file that another changed.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import {
    button, openBrowser, trialOf as trial, typeInto, waitLive, withPage as withMock,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 60_000;
const AT = '#/boat/config';

const withPage = (options, body) => withMock(browser, { at: AT, ...options }, async (view) => {
    await view.page.locator('.cm-content').waitFor();
    await body(view);
});
const typeAtStart = (page, text) => typeInto(page, text, 'Home');

async function startTrial(page, text = '# changed\n') {
    await typeAtStart(page, text);
    await button(page, 'Try for 30 s').click();
    await trial(page).getByText(/On trial: \d+ s left/).waitFor();
}

test('a mistake is marked at its place and listed; it cannot be tried', { timeout }, async () => {
    await withPage({}, async ({ page }) => {
        await typeAtStart(page, '  nonsense = 3\n');
        await button(page, '1:3: unknown key "nonsense"; allowed: "protocol", "device", "timeout"')
            .click();
        assert.equal(await page.locator('.cm-lintRange-error').innerText(), 'nonsense');
        assert.equal(await button(page, 'Try for 30 s').isDisabled(), true);
        // The place of the mistake has the focus: what is typed lands there.
        await page.keyboard.insertText('#');
        assert.match(await page.locator('.cm-line').first().innerText(), /^ {2}#nonsense/);
    });
});

test('the check waits 300 ms after the last key', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await page.getByText('The same as what runs.').waitFor();
        const checks = () => board.requests.filter((one) => one.endsWith('/check')).length;
        const at = checks();
        await page.locator('.cm-content').click();
        await page.keyboard.type('# ten keys', { delay: 60 });
        assert.equal(checks(), at);
        await page.getByText('What changes').waitFor();
        assert.equal(checks(), at + 1);
        assert.match(await page.locator('.diff').innerText(), /hold: 300ms before, now 200ms/);
    });
});

test('try and keep: the file is written once it is kept', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await startTrial(page);
        assert.ok(!board.fileOf('boat').text.startsWith('# changed'));
        // The trial stands on every screen, keep and back at the same place.
        await page.getByRole('link', { name: 'Live' }).first().click();
        const place = await button(page, 'Keep').boundingBox();
        await page.getByRole('link', { name: 'Configuration' }).click();
        assert.deepEqual(await button(page, 'Keep').boundingBox(), place);
        await button(page, 'Keep').click();
        await trial(page).getByText('Kept: the new configuration runs').waitFor();
        assert.ok(board.fileOf('boat').text.startsWith('# changed'));
        // The draft knows the new file: another trial is no conflict.
        await startTrial(page, '# again\n');
        await button(page, 'Back').click();
        await trial(page).getByText('The configuration before runs again.').waitFor();
        assert.ok(!board.fileOf('boat').text.startsWith('# again'));
    });
});

test('seconds run down; a trial that nobody keeps goes back by itself', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await startTrial(page);
        await trial(page).getByText(/ 2[789] s left/).waitFor();
        board.fileOf('boat').trial.until = performance.now() + 1500;
        await trial(page).getByText('the board went back to the configuration before').waitFor();
        await page.getByText('# changed').waitFor();
    });
});

test('a board that is not heard during a trial: the page counts itself', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await startTrial(page);
        board.sends = false;
        await trial(page).getByText('By this page\'s clock').waitFor();
        board.sends = true;
        await trial(page).getByText('It goes back by itself.').waitFor();
    });
});

test('an old trial cannot be kept', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await startTrial(page);
        board.sends = false;
        board.fileOf('boat').trial = null;
        await button(page, 'Keep').click();
        await trial(page).getByText('This trial is over, or another one runs.').waitFor();
    });
});

test('a trial from elsewhere is shown and can be taken back', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await waitLive(page);
        board.startTrial('boat', 'x', 20);
        await trial(page).getByText(/started elsewhere/).waitFor();
        await button(page, 'Back').click();
        await trial(page).getByText('The configuration before runs again.').waitFor();
    });
});

test('changed by another: both edits are merged, a conflict asks', { timeout }, async () => {
    await withPage({}, async ({ page, board }) => {
        await typeAtStart(page, '# mine\n');
        await page.getByText('What changes').waitFor();
        board.changeByAnother('boat',
            `# theirs\n${board.fileOf('boat').text.replace('300ms', '150ms')}`);
        await button(page, 'Try for 30 s').click();
        await page.getByText('The file was changed by another meanwhile').waitFor();
        assert.equal(await button(page, 'Choose 1 more').isDisabled(), true);
        await page.getByLabel('Both, theirs first').check();
        await button(page, 'Edit the merged text').click();
        const text = await page.locator('.cm-content').innerText();
        assert.match(text, /^# theirs\n# mine\n# The boat/);
        assert.match(text, /150ms/);
        await button(page, 'Try for 30 s').click();
        await trial(page).getByText(/On trial/).waitFor();
    });
});

test('the draft outlives another screen and a reload', { timeout }, async () => {
    await withPage({}, async ({ page }) => {
        await typeAtStart(page, '# not lost\n');
        await page.getByRole('link', { name: 'Live' }).first().click();
        await page.reload();
        await page.getByRole('link', { name: 'Configuration' }).click();
        await page.getByText('# not lost').waitFor();
        await button(page, 'Drop my changes').click();
        await page.getByText('# not lost').waitFor({ state: 'detached' });
    });
});

test('who may only look cannot edit, and reads why', { timeout }, async () => {
    await withPage({ board: (b) => { b.role = 'look'; } }, async ({ page }) => {
        await page.getByText('This browser may only look.').waitFor();
        await typeAtStart(page, 'no');
        assert.match(await page.locator('.cm-content').innerText(), /^# The boat/);
        assert.equal(await button(page, 'Try for 30 s').count(), 0);
    });
});

test('a daemon that does not run: mended and written from the page', { timeout }, async () => {
    const options = { at: '#/spare/config', board: (b) => {
        b.files.spare.text = 'nonsense = 1\n';
    } };
    await withPage(options, async ({ page, board }) => {
        await page.getByText('unknown key "nonsense"').first().waitFor();
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+A');
        await page.keyboard.insertText('# good\n');
        await button(page, 'Write to the file').click();
        await page.getByText('Written to the file.').waitFor();
        assert.equal(board.fileOf('spare').text, '# good\n');
    });
});

test('keys, tables and values are completed from the schema', { timeout }, async () => {
    const schema = { type: 'object', properties: { input: { type: 'object', patternProperties: {
        '^[a-z]+$': { type: 'object', properties: {
            protocol: { enum: ['ibus', 'sbus'] }, timeout: { type: 'string', default: '100ms' },
            device: { type: 'string' } } } } } } };
    await withPage({ board: (b) => { b.schema = schema; } }, async ({ page }) => {
        await page.waitForTimeout(300);
        await typeAtStart(page, '[input.a]\n\n');
        await page.keyboard.press('ArrowUp');
        await page.keyboard.type('pro');
        await page.locator('.cm-tooltip-autocomplete').getByText('protocol').waitFor();
        await page.waitForTimeout(150);
        await page.keyboard.press('Enter');
        await page.keyboard.type('"s');
        await page.locator('.cm-tooltip-autocomplete').getByText('"sbus"').waitFor();
        await page.waitForTimeout(150);
        await page.keyboard.press('Enter');
        assert.match(await page.locator('.cm-content').innerText(),
            /^\[input.a\]\nprotocol = "sbus"/);
    });
});
