// Who is not paired, and what does not arrive: before the real server and the real daemon.
import assert from 'node:assert/strict';
import { cp, mkdtemp, readdir, readFile, rm, writeFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { after, before, test } from 'node:test';
import {
    openBrowser, pairBy, sees, waitLive, withBoard as withReal,
} from './browser.mjs';

let browser;
before(async () => { browser = await openBrowser(); });
after(async () => { await browser.close(); });

const timeout = 90_000;
const withBoard = (options, body) => withReal(browser, options, body);

/** What a page of another origin can do with this address; runs in that page. */
async function attack(target) {
    const attempt = (url, options) => fetch(url, { credentials: 'include', ...options })
        .then((answer) => answer.type, (error) => error.name);
    const loads = (tag, url) => new Promise((done) => {
        const element = document.createElement(tag);
        element.onload = () => done('loaded');
        element.onerror = () => done('error');
        element.src = url;
        document.body.append(element);
    });
    const events = new Promise((done) => {
        const source = new EventSource(`${target}api/boat/stream`, { withCredentials: true });
        source.onopen = () => done('open');
        source.addEventListener('status', () => done('status'));
        source.onerror = () => { source.close(); done('error'); };
    });
    const body = JSON.stringify({ toml: '', seconds: 30 });
    const form = document.createElement('form');
    Object.assign(form, { action: `${target}api/boat/draft`, method: 'post', target: 'inside',
        enctype: 'text/plain' });
    const frame = document.createElement('iframe');
    frame.name = 'inside';
    document.body.append(form, frame);
    form.submit();
    return {
        post: await attempt(`${target}api/boat/draft`, { method: 'POST', body,
            headers: { 'Content-Type': 'application/json', 'X-Tribus': '1' } }),
        plainPost: await attempt(`${target}api/boat/draft`, { method: 'POST', body,
            mode: 'no-cors' }),
        read: await attempt(`${target}api/boat/status`, {}),
        quietRead: await attempt(`${target}api/boat/status`, { mode: 'no-cors' }),
        events: await events,
        script: await loads('script', `${target}api/boat/status`),
        picture: await loads('img', `${target}api/boat/graph.svg`),
    };
}

test('a page of another origin posts, streams and frames nothing', { timeout }, async () => {
    const foreign = createServer((_, response) => {
        response.setHeader('Content-Type', 'text/html');
        response.end('<!doctype html><title>foreign</title><body><p>foreign</p>');
    });
    await new Promise((ready) => { foreign.listen(0, '127.0.0.1', ready); });
    const elsewhere = foreign.address().port;
    try {
        await withBoard({}, async ({ page, board, context, address, foreign: requests }) => {
            await waitLive(page);
            const before = await board.text();
            const attacker = await context.newPage();
            const answers = [];
            attacker.on('response', (answer) => answers.push(answer));
            // Another port has the same cookies, another host has none.
            for (const host of ['127.0.0.1', 'evil.example']) {
                await attacker.goto(`http://${host}:${elsewhere}/`);
                answers.length = 0;
                const got = await attacker.evaluate(attack, address);
                // What cannot be read may seem to have passed: an answer with an error did not.
                delete got.plainPost;
                assert.deepEqual(got, { post: 'TypeError', read: 'TypeError',
                    quietRead: 'TypeError', events: 'error', script: 'error', picture: 'error' });
                const posts = answers.filter((one) => one.request().method() === 'POST');
                assert.ok(posts.length > 0);
                for (const one of posts) {
                    assert.ok(one.status() >= 400, `${one.url()} was answered ${one.status()}`);
                }
                await attacker.evaluate((at) => new Promise((done) => {
                    const frame = document.createElement('iframe');
                    frame.onload = done;
                    frame.src = at;
                    document.body.append(frame);
                }), address);
                const framed = attacker.frames().filter((one) => one !== attacker.mainFrame());
                for (const frame of framed) {
                    assert.equal(await frame.locator('#app, #page').count(), 0);
                    assert.doesNotMatch(frame.url(), /^http/);
                }
            }
            assert.equal(await board.text(), before);
            const { trial } = await page.evaluate(async () =>
                (await fetch('/api/boat/status')).json());
            assert.equal(trial, null);
            await waitLive(page);

            // A name that its owner lets resolve to this board.
            const { port } = new URL(address);
            for (const path of ['', 'api/me', 'api/boat/stream']) {
                const answer = await attacker.goto(`http://evil.example:${port}/${path}`);
                assert.equal(answer.status(), 421);
                assert.match(await answer.text(), /this machine has another name/);
            }
            requests.length = 0; // The attacker's own.
        });
    } finally {
        foreign.close();
    }
});

test('wrong, expired, revoked: the page asks for a code, never empty', { timeout }, async () => {
    await withBoard({ pairs: false }, async ({ page, board }) => {
        const asks = () => page.getByRole('heading', { name: /^Pair with/ }).waitFor();
        const change = async (name, how) => {
            const file = join(board.state, name);
            await writeFile(file, JSON.stringify(how(JSON.parse(await readFile(file, 'utf8')))));
        };
        await asks();
        await pairBy(page, 'AAAAAAAA');
        await sees(page, 'no code is valid now');
        const code = await board.code();
        await pairBy(page, 'AAAAAAAA');
        await sees(page, 'The next one counts in 1 s.');
        await page.waitForTimeout(1100);
        const past = Math.floor(Date.now() / 1000) - 1;
        await change('code.json', (made) => ({ ...made, until: past }));
        await pairBy(page, code);
        await sees(page, 'Run sudo tribus pair on the board again');
        await page.getByLabel(/^Name of this browser/).fill('phone');
        await pairBy(page, (await board.code()).toLowerCase());
        await waitLive(page);
        await board.pairing('--revoke', 'phone');
        await asks();
        await pairBy(page, await board.code());
        await waitLive(page);
        const longAgo = Math.floor(Date.now() / 1000) - 91 * 24 * 3600;
        await change('sessions.json', (all) => all.map((one) => ({ ...one, made: longAgo })));
        await asks();
        await page.reload();
        await asks();
    });
});

/** The built page without the files whose names match. */
async function pageWithout(pattern) {
    const folder = await mkdtemp(join(tmpdir(), 'tribus-page-'));
    await cp(resolve(dirname(fileURLToPath(import.meta.url)), '../dist'), folder,
        { recursive: true });
    for (const name of await readdir(join(folder, 'assets'))) {
        if (pattern.test(name)) {
            await rm(join(folder, 'assets', name));
        }
    }
    return folder;
}

test('a script, the style or a part that is missing leaves words', { timeout }, async () => {
    const cases = [
        [/^page-.*\.js/, false, 'The page could not be loaded'],
        [/^style-.*\.css/, false, 'Without its style'],
        [/^(part|editor)-/, true, 'The editor did not arrive.'],
    ];
    for (const [pattern, pairs, words] of cases) {
        const page = await pageWithout(pattern);
        const options = { page, pairs: pairs ? [] : false, at: pairs ? '#/boat/config' : '' };
        await withBoard(options, ({ page: shown }) => sees(shown, words));
        await rm(page, { recursive: true });
    }
});
