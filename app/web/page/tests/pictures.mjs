// Writes a picture of every screen:  node tests/pictures.mjs FOLDER [NAME...]
import { mkdir } from 'node:fs/promises';
import { openBrowser, openPage } from './browser.mjs';

const [folder = 'pictures', ...only] = process.argv.slice(2);
const SHOTS = {
    live: { at: '#/boat/live' },
    live_hold: { at: '#/boat/live', board: (b) => { b.scenes.boat = 'hold'; } },
    live_failsafe: { at: '#/boat/live', board: (b) => { b.scenes.boat = 'failsafe'; } },
    live_never: { at: '#/boat/live', board: (b) => { b.scenes.boat = 'never_seen'; } },
    live_silent: { at: '#/boat/live', board: (b) => { b.scenes.boat = 'silent'; } },
    live_rover: { at: '#/rover/live' },
    live_absent: { at: '#/spare/live', notLive: true },
    live_stale: { at: '#/boat/live', then: async (page, b) => {
        b.sends = false;
        await page.waitForTimeout(1600);
    } },
    live_hung: { at: '#/boat/live', notLive: true, board: (b) => {
        b.extra = { figures_age_us: 4_200_000 };
    } },
    pair: { board: (b) => { b.paired = false; }, notLive: true },
    config: { at: '#/boat/config', wait: '.editor' },
    config_mistake: { at: '#/boat/config', wait: '.editor', then: async (page) => {
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+Home');
        await page.keyboard.type('nonsense = 3\n');
        await page.waitForTimeout(1000);
    } },
    config_trial: { at: '#/boat/config', wait: '.editor', then: async (page) => {
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+Home');
        await page.keyboard.type('# changed\n');
        await page.waitForTimeout(1000);
        await page.getByRole('button', { name: /Try for 30 s/ }).click();
        await page.waitForTimeout(800);
    } },
    config_merge: { at: '#/boat/config', wait: '.editor', then: async (page, b) => {
        await page.locator('.cm-content').click();
        await page.keyboard.press('Control+Home');
        await page.keyboard.type('# mine\n');
        b.changeByAnother('boat', b.fileOf('boat').text.replace('300ms', '150ms'));
        await page.waitForTimeout(1000);
        await page.getByRole('button', { name: /Try for 30 s/ }).click();
        await page.waitForTimeout(800);
    } },
    timing: { at: '#/boat/timing', then: async (page, b) => {
        await page.waitForTimeout(3000);
        b.scenes.boat = 'failsafe';
        await page.waitForTimeout(3000);
    } },
    doctor: { at: '#/boat/doctor', then: (page) => page.waitForTimeout(800) },
    learn: { at: '#/boat/learn', then: (page) => page.waitForTimeout(500) },
    recordings: { at: '#/boat/recordings', then: async (page) => {
        await page.getByRole('button', { name: /Plot/ }).first().click();
        await page.waitForTimeout(1200);
    } },
    more: { at: '#/boat/more' },
};

await mkdir(folder, { recursive: true });
const browser = await openBrowser();
for (const [name, shot] of Object.entries(SHOTS)) {
    if (only.length > 0 && !only.includes(name)) {
        continue;
    }
    for (const scheme of ['dark', 'light']) {
        for (const width of [360, 1280]) {
            const view = await openPage(browser, { ...shot, scheme, width,
                height: width === 360 ? 740 : 900 });
            try {
                await (shot.notLive ? view.page.waitForTimeout(900)
                    : view.page.locator('.lamp.live').waitFor());
                if (shot.wait) {
                    await view.page.locator(shot.wait).first().waitFor();
                }
                await shot.then?.(view.page, view.board);
            } catch (error) {
                console.log(`${name} ${width}: ${String(error).slice(0, 200)}`);
            }
            await view.page.screenshot({ path: `${folder}/${name}-${scheme}-${width}.png` });
            if (view.problems.length > 0) {
                console.log(name, view.problems);
            }
            await view.close();
        }
    }
}
await browser.close();
