// Renders scenes with peers (other engines) in a headless Chromium. Each line of the input is a job in JSON: {peer,
// scene, settings, out}. With `settings` null, the picture has no reflections. The answer to each job is a line: {},
// {said} with the first complaint of the browser, or {error}. Before the first job, a line has the version of Chromium
// and the title, npm package and settings of each peer.
//
// Usage: node drive.mjs PEERS PACKAGES CHROMIUM       PACKAGES is a folder with node_modules

import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { readFile, readdir } from 'node:fs/promises';
import { extname, join, normalize } from 'node:path';
import { createInterface } from 'node:readline';

const [peers, packages, executablePath] = process.argv.slice(2);
const { chromium } = createRequire(join(packages, 'package.json'))('playwright-core');
const TYPES = { '.js': 'text/javascript', '.mjs': 'text/javascript', '.json': 'application/json', '.html': 'text/html', '.wasm': 'application/wasm' };
const IMPORTS = {
    three: '/node_modules/three/build/three.module.js',
    'three/webgpu': '/node_modules/three/build/three.webgpu.js',
    'three/tsl': '/node_modules/three/build/three.tsl.js',
    'three/addons/': '/node_modules/three/examples/jsm/',
    '@babylonjs/core/': '/node_modules/@babylonjs/core/',
};
const PAGE = `<!doctype html><meta charset="utf-8"><style>body { margin: 0 } canvas { display: block }</style>
<script type="importmap">${JSON.stringify({ imports: IMPORTS })}</script>`;

const server = createServer(async (request, response) => {
    const path = normalize(decodeURIComponent(new URL(request.url, 'http://host').pathname));
    if (path === '/') {
        response.writeHead(200, { 'content-type': TYPES['.html'] }).end(PAGE);
        return;
    }
    const file = path.startsWith('/peers/') ? join(peers, path.slice('/peers/'.length)) : join(packages, path);
    try {
        const body = await readFile(file);
        response.writeHead(200, { 'content-type': TYPES[extname(file)] ?? 'application/octet-stream' }).end(body);
    } catch {
        response.writeHead(404).end();
    }
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
const address = `http://127.0.0.1:${server.address().port}/`;

const browser = await chromium.launch({
    executablePath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--force-color-profile=srgb', '--force-device-scale-factor=1'],
});
const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
let complaints = [];
page.on('pageerror', (error) => complaints.push(String(error)));
page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));

// Returns the title, the npm package and the settings of a peer.
async function describe(name) {
    await page.goto(address);
    return page.evaluate(async (module) => {
        const { title, npm, settings } = await import(module);
        return { title, npm, settings };
    }, `/peers/${name}.mjs`);
}

// Renders a job, and writes a screenshot of the canvas to the file `out`.
async function run({ peer, scene, settings, out }) {
    complaints = [];
    await page.goto(address);
    const read = JSON.parse(await readFile(scene, 'utf8'));
    await page.setViewportSize({ width: read.width, height: read.height });
    await page.evaluate(async ([module, scene, settings]) => {
        const canvas = document.createElement('canvas');
        canvas.width = scene.width;
        canvas.height = scene.height;
        canvas.style.width = `${scene.width}px`;
        canvas.style.height = `${scene.height}px`;
        document.body.append(canvas);
        const { render } = await import(module);
        await render(canvas, scene, settings);
    }, [`/peers/${peer}.mjs`, read, settings]);
    await page.screenshot({ path: out, clip: { x: 0, y: 0, width: read.width, height: read.height } });
    return complaints.length > 0 ? { said: complaints[0].slice(0, 300) } : {};
}

const names = (await readdir(peers)).filter((f) => f.endsWith('.mjs') && !f.endsWith('-scene.mjs')).map((f) => f.slice(0, -4)).sort();
const known = {};
for (const name of names)
    known[name] = await describe(name);
console.log(JSON.stringify({ chromium: browser.version(), peers: known }));
for await (const line of createInterface({ input: process.stdin })) {
    let answer;
    try {
        answer = await run(JSON.parse(line));
    } catch (error) {
        answer = { error: String(error).split('\n')[0] };
    }
    console.log(JSON.stringify(answer));
}
await browser.close();
server.close();
