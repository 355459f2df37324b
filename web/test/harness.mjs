// What the checks of the page are made with: pages in Chromium, servers of `tulle view`, pixels.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import zlib from 'node:zlib';

export const [place, tulle, chromium] = process.argv.slice(2).map((each) => path.resolve(each));
export const root = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../..');
export const load = createRequire(path.join(place, 'x'));
export const pictures = path.join(place, 'pictures'),
  work = path.join(place, 'work');
const ARGUMENTS = [
  '--no-sandbox',
  '--disable-gpu',
  '--disable-quic',
  '--no-first-run',
  '--disable-background-networking',
  '--disable-component-update',
  '--disable-sync',
];

export const browser = await load('playwright-core').chromium.launch({ executablePath: chromium, args: ARGUMENTS });

// ---- servers ----

const servers = new Set();

// Starts `tulle view` and gives its address; `stop` ends it as Ctrl-C does.
export async function serve(...args) {
  const child = spawn(tulle, ['view', '--no-browser', ...args], { cwd: work, stdio: ['ignore', 'pipe', 'pipe'] });
  servers.add(child);
  let said = '';
  const address = await new Promise((done, fail) => {
    const timer = setTimeout(() => fail(new Error(`tulle view gave no address: ${said}`)), 30000);
    const listen = (data) => {
      said += data;
      const found = /http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\//.exec(said);
      if (!found) return;
      clearTimeout(timer);
      done(found[0]);
    };
    child.stdout.on('data', listen);
    child.stderr.on('data', listen);
    child.on('exit', (code) => fail(new Error(`tulle view ended with ${code}: ${said}`)));
  });
  const stop = () =>
    new Promise((done) => {
      servers.delete(child);
      if (child.exitCode !== null) return done();
      child.on('exit', done);
      child.kill('SIGINT');
    });
  return { address, stop };
}

export function stopAll() {
  for (const child of servers) child.kill('SIGKILL');
}

export const run = (...args) => execFileSync(tulle, args, { cwd: work, encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'] });

// ---- pages ----

// A page of a server with its requests and errors noted; `options` are those of a context.
export async function open(address, { prepare, fragment = '', ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1000, height: 640 }, acceptDownloads: true, ...options });
  context.setDefaultTimeout(20000);
  const page = await context.newPage(),
    seen = { requests: [], errors: [] };
  page.on('request', (request) => seen.requests.push(request.url()));
  page.on('pageerror', (error) => seen.errors.push(error.stack));
  page.on('console', (message) => message.type() === 'error' && seen.errors.push(message.text()));
  if (prepare) await prepare(page);
  await page.goto(address + fragment);
  return { page, seen, address, view: page.getByRole('application') };
}

export async function close({ page, seen, address }, { expected = [] } = {}) {
  const origin = new URL(address).origin,
    away = seen.requests.filter(
      (each) =>
        !/^(data|blob):/.test(each) && new URL(each).origin !== origin && !each.startsWith(origin.replace('http', 'ws')),
    );
  assert.deepEqual(away, [], 'a request left the page');
  assert.deepEqual(
    seen.errors.filter((error) => !expected.some((each) => error.includes(each))),
    [],
  );
  await page.context().close();
}

// Asks again until it holds, for the page and the server take their time.
export async function until(condition, message, milliseconds = 15000) {
  for (const end = Date.now() + milliseconds; Date.now() < end; await new Promise((done) => setTimeout(done, 40))) {
    const value = await condition();
    if (value) return value;
  }
  return assert.fail(message);
}

export const getFrame = async (view) => Number(await view.getAttribute('data-drawn'));
export const waitFrame = (view, frame) =>
  until(async () => {
    const drawn = await view.getAttribute('data-drawn');
    return drawn !== null && drawn !== '' && (frame === undefined || Number(drawn) === frame);
  }, `frame ${frame} is not drawn`);

export const section = (page, title) =>
  page.locator('#panels details').filter({ has: page.locator('summary', { hasText: new RegExp(`^${title}`) }) });

export async function openSection(page, title) {
  const details = section(page, title);
  if ((await details.getAttribute('open')) === null) await details.locator('summary').click();
  return details;
}

// The facts of the panel of the selection: name to text.
export const readFacts = (page) =>
  section(page, 'Selection')
    .locator('.facts')
    .first()
    .evaluate((list) =>
      Object.fromEntries(
        [...list.querySelectorAll('dt')].map((each) => [each.textContent, each.nextElementSibling.textContent]),
      ),
    );

export const toNumber = (text) => Number(text.replaceAll('\u2212', '-'));
export const toNumbers = (text) => text.split(',').map(toNumber);

// ---- pixels ----

// The pixels of a PNG file of 8 bits that is not interlaced.
export function readPng(file) {
  const parts = [];
  let width, height, channels;
  for (let at = 8; at < file.length; at += 12 + file.readUInt32BE(at)) {
    const kind = file.toString('latin1', at + 4, at + 8),
      body = file.subarray(at + 8, at + 8 + file.readUInt32BE(at));
    if (kind === 'IHDR') [width, height, channels] = [body.readUInt32BE(0), body.readUInt32BE(4), { 2: 3, 6: 4 }[body[9]]];
    if (kind === 'IDAT') parts.push(body);
  }
  const rows = zlib.inflateSync(Buffer.concat(parts)),
    row = width * channels,
    data = new Uint8Array(row * height);
  for (let y = 0; y < height; y++) {
    const filter = rows[y * (row + 1)];
    for (let x = 0; x < row; x++) {
      const left = x >= channels ? data[y * row + x - channels] : 0,
        up = y ? data[(y - 1) * row + x] : 0;
      const corner = x >= channels && y ? data[(y - 1) * row + x - channels] : 0;
      const [a, b, c] = [Math.abs(up - corner), Math.abs(left - corner), Math.abs(left + up - 2 * corner)];
      data[y * row + x] =
        rows[y * (row + 1) + 1 + x] + [0, left, up, (left + up) >> 1, a <= b && a <= c ? left : b <= c ? up : corner][filter];
    }
  }
  return { width, height, channels, data };
}

export const look = async (page, name) =>
  readPng(await page.locator('#stage').screenshot(name ? { path: path.join(pictures, `${name}.png`) } : {}));

// The share of pixels for which `test` holds of red, green and blue.
export function measure({ width, height, channels, data }, test) {
  let count = 0;
  for (let i = 0; i < data.length; i += channels) if (test(data[i], data[i + 1], data[i + 2])) count++;
  return count / (width * height);
}

// The share of pixels in which two pictures differ.
export function compare(a, b) {
  assert.equal(a.data.length, b.data.length);
  let count = 0;
  for (let i = 0; i < a.data.length; i += a.channels)
    if (
      Math.abs(a.data[i] - b.data[i]) + Math.abs(a.data[i + 1] - b.data[i + 1]) + Math.abs(a.data[i + 2] - b.data[i + 2]) >
      24
    )
      count++;
  return count / (a.width * a.height);
}

export async function differs(page, before, share, message) {
  let picture;
  await until(async () => compare(before, (picture = await look(page))) > share, message);
  return picture;
}

// The picture once two that follow each other are the same.
export async function settle(page) {
  let before = await look(page);
  await until(async () => {
    await page.waitForTimeout(250);
    const isCoarse = await page.locator('#view').getAttribute('data-coarse');
    const now = await look(page),
      isSame = isCoarse === null && compare(before, now) < 1e-4;
    before = now;
    return isSame;
  }, 'the picture does not come to rest');
  return before;
}

// ---- files ----

export function readPc2(file) {
  const bytes = fs.readFileSync(file),
    vertexCount = bytes.readInt32LE(16),
    frameCount = bytes.readInt32LE(28);
  return {
    vertexCount,
    frameCount,
    get: (frame, vertex) => [0, 1, 2].map((axis) => bytes.readFloatLE(32 + 4 * (3 * (vertexCount * frame + vertex) + axis))),
  };
}

// ---- the list of checks ----

export async function check(checks) {
  const chosen = process.argv[5] ? new RegExp(process.argv[5]) : /./;
  let failures = 0,
    count = 0;
  for (const [name, body] of Object.entries(checks)) {
    if (!chosen.test(name)) continue;
    const start = Date.now();
    count++;
    try {
      await body();
      console.log(`ok: ${name} (${((Date.now() - start) / 1000).toFixed(1)} s)`);
    } catch (problem) {
      failures++;
      console.log(`failed: ${name}\n${problem.stack}`);
      for (const context of browser.contexts()) {
        for (const page of context.pages())
          await page
            .screenshot({ path: path.join(pictures, `failed_${name.replace(/\W+/g, '_').slice(0, 60)}.png`), timeout: 5000 })
            .catch(() => {});
        await context.close();
      }
    }
  }
  return { failures, count };
}
