// Bundles the page into dist/ and checks its size:
//   node build.mjs [FOLDER]        FOLDER is dist/ unless given
import { build } from 'esbuild';
import { mkdir, readFile, readdir, rm, writeFile } from 'node:fs/promises';
import { basename, dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const target = resolve(process.argv[2] ?? join(here, 'dist'));
const KB = 1000;
const FIRST_SCREEN_LIMIT = 45 * KB;
const WHOLE_LIMIT = 220 * KB;

async function bundle() {
    const result = await build({
        absWorkingDir: here,
        entryPoints: {
            page: 'src/main.tsx', style: 'src/style.css', uplot: 'src/timing/uplot.css',
        },
        outdir: join(target, 'assets'),
        entryNames: '[name]-[hash]',
        chunkNames: 'part-[hash]',
        bundle: true,
        splitting: true,
        format: 'esm',
        minify: true,
        metafile: true,
        target: ['es2022'],
        jsx: 'automatic',
        jsxImportSource: 'preact',
        legalComments: 'none',
    });
    const made = Object.entries(result.metafile.outputs);
    const outputOf = (entry) => made.find(([, output]) => output.entryPoint === entry)[0];
    return {
        script: outputOf('src/main.tsx'),
        style: outputOf('src/style.css'),
        plotStyle: outputOf('src/timing/uplot.css'),
        outputs: result.metafile.outputs,
    };
}

/// What the browser loads before it draws: the entry and the chunks that it imports at once.
function firstScripts(outputs, entry, found = new Set()) {
    found.add(entry);
    for (const one of outputs[entry].imports) {
        if (one.kind === 'import-statement' && !found.has(one.path)) {
            firstScripts(outputs, one.path, found);
        }
    }
    return found;
}

async function writeHtml(made) {
    const template = await readFile(join(here, 'src/index.html'), 'utf8');
    const preloads = [...firstScripts(made.outputs, made.script)]
        .filter((path) => path !== made.script)
        .map((path) => `<link rel="modulepreload" href="/assets/${basename(path)}">`);
    const html = template
        .replace('PRELOADS', preloads.join(''))
        .replace('SCRIPT', `/assets/${basename(made.script)}`)
        .replace('PLOT_STYLE', `/assets/${basename(made.plotStyle)}`)
        .replace('STYLE', `/assets/${basename(made.style)}`);
    await writeFile(join(target, 'index.html'), html);
}

async function gzipSizes() {
    const names = ['index.html'];
    for (const name of (await readdir(join(target, 'assets'))).sort()) {
        names.push(`assets/${name}`);
    }
    const sizes = new Map();
    for (const name of names) {
        sizes.set(name, gzipSync(await readFile(join(target, name)), { level: 9 }).length);
    }
    return sizes;
}

function checkSizes(sizes, first) {
    let firstScreen = 0;
    let whole = 0;
    for (const [name, size] of sizes) {
        whole += size;
        firstScreen += first.has(name) ? size : 0;
        console.log(`${String(size).padStart(7)}  ${name}${first.has(name) ? '  (first)' : ''}`);
    }
    const line = (size, text) => console.log(`${String(size).padStart(7)}  ${text}`);
    line(firstScreen, `first screen, of at most ${FIRST_SCREEN_LIMIT}`);
    line(whole, `everything, of at most ${WHOLE_LIMIT}`);
    if (firstScreen > FIRST_SCREEN_LIMIT || whole > WHOLE_LIMIT) {
        console.error('The page is too big.');
        process.exitCode = 1;
    }
}

await rm(target, { recursive: true, force: true });
await mkdir(target, { recursive: true });
const made = await bundle();
await writeHtml(made);
const first = new Set(['index.html', `assets/${basename(made.style)}`]);
for (const path of firstScripts(made.outputs, made.script)) {
    first.add(`assets/${basename(path)}`);
}
checkSizes(await gzipSizes(), first);
