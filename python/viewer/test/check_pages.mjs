// Looks at the pages of make_pages.py in a browser: what is drawn, what keys do, that nobody is asked for anything.
// node check_pages.mjs DIRECTORY CHROMIUM      DIRECTORY holds node_modules with playwright-core, and pages
import assert from 'node:assert/strict';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import zlib from 'node:zlib';

const [place, chromium] = process.argv.slice(2).map((each) => path.resolve(each));
const { chromium: launcher } = createRequire(path.join(place, 'x'))('playwright-core');
const ARGUMENTS = ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync'];
const WIDE = { width: 800, height: 460 };

const browser = await launcher.launch({ executablePath: chromium, args: ARGUMENTS });

// ---- tools ----

// A page with its requests and errors noted; `options` are those of a context.
async function open(name, options = {}, prepare = () => {}) {
  const context = await browser.newContext({ viewport: WIDE, ...options });
  const page = await context.newPage();
  const seen = { requests: [], errors: [] };
  page.on('request', (request) => seen.requests.push(request.url()));
  page.on('pageerror', (error) => seen.errors.push(error.message));
  page.on('console', (message) => message.type() === 'error' && seen.errors.push(message.text()));
  await prepare(page);
  const url = `file://${place}/pages/${name}.html`;
  await page.goto(url);
  return { page, seen, url, view: page.getByRole('application') };
}

async function close({ page, seen, url }) {
  assert.deepEqual(seen.requests.filter((each) => each !== url && !/^(data|blob|about):/.test(each)), [], 'a request left the page');
  assert.deepEqual(seen.errors, []);
  await page.context().close();
}

const waitFrame = (view, frame) => view.evaluate((element, wanted) => new Promise((done, fail) => {
  const end = performance.now() + 60000;
  const look = () => {
    const drawn = element.dataset.drawn;
    if (drawn !== undefined && (wanted === undefined || Number(drawn) === wanted)) requestAnimationFrame(() => requestAnimationFrame(done));
    else if (performance.now() > end) fail(new Error(`frame ${wanted} is not drawn; ${drawn} is`));
    else setTimeout(look, 20);
  };
  look();
}), frame);

// The pixels of a PNG file as browsers write it, of 8 bits and not interlaced: red, green, blue and what else there is.
function readPng(file) {
  const parts = [];
  let width, height, channels;
  for (let place = 8; place < file.length; place += 12 + file.readUInt32BE(place)) {
    const kind = file.toString('latin1', place + 4, place + 8), body = file.subarray(place + 8, place + 8 + file.readUInt32BE(place));
    if (kind === 'IHDR') [width, height, channels] = [body.readUInt32BE(0), body.readUInt32BE(4), { 2: 3, 6: 4 }[body[9]]];
    if (kind === 'IDAT') parts.push(body);
  }
  const rows = zlib.inflateSync(Buffer.concat(parts)), row = width * channels, data = new Uint8Array(row * height);
  for (let y = 0; y < height; y++) {
    const filter = rows[y * (row + 1)];
    for (let x = 0; x < row; x++) {
      const left = x >= channels ? data[y * row + x - channels] : 0, up = y ? data[(y - 1) * row + x] : 0;
      const corner = x >= channels && y ? data[(y - 1) * row + x - channels] : 0;
      const [a, b, c] = [Math.abs(up - corner), Math.abs(left - corner), Math.abs(left + up - 2 * corner)];
      const guess = [0, left, up, (left + up) >> 1, a <= b && a <= c ? left : b <= c ? up : corner][filter];
      data[y * row + x] = rows[y * (row + 1) + 1 + x] + guess;
    }
  }
  return { width, height, channels, data };
}

// The pixels of what is shown of an element.
async function look(locator, name) {
  return readPng(await locator.screenshot(name ? { path: path.join(place, 'pages', `${name}.png`) } : {}));
}

// The share of pixels for which `test` holds of red, green and blue, and the box that they fill, in shares of the picture.
function measure({ width, height, channels, data }, test) {
  let count = 0;
  const box = { left: width, right: 0, top: height, bottom: 0 };
  for (let i = 0; i < width * height; i++) {
    if (!test(data[channels * i], data[channels * i + 1], data[channels * i + 2])) continue;
    const x = i % width, y = Math.floor(i / width);
    count++;
    Object.assign(box, { left: Math.min(box.left, x), right: Math.max(box.right, x), top: Math.min(box.top, y), bottom: Math.max(box.bottom, y) });
  }
  return { share: count / (width * height), left: box.left / width, right: box.right / width, top: box.top / height, bottom: box.bottom / height };
}

const isBlue = (r, g, b) => b > r + 40 && b > 60; // cloth
const isGrey = (r, g, b) => Math.abs(r - b) < 20 && b < 215 && b > 60; // obstacles
const isGround = (r, g, b) => r === 243 && g === 245 && b === 247;

// The share of pixels in which two pictures differ.
function compare(a, b) {
  assert.equal(a.data.length, b.data.length);
  let count = 0;
  for (let i = 0; i < a.data.length; i += a.channels)
    if (Math.abs(a.data[i] - b.data[i]) + Math.abs(a.data[i + 1] - b.data[i + 1]) + Math.abs(a.data[i + 2] - b.data[i + 2]) > 24) count++;
  return count / (a.width * a.height);
}

// Asks again until it holds, for pictures come a little after what makes them.
async function until(condition, message) {
  for (const end = Date.now() + 60000; Date.now() < end;) if (await condition()) return;
  assert.fail(message);
}

const getFocus = (page) => page.evaluate(() => {
  const element = document.activeElement, style = getComputedStyle(element);
  return { tag: element.tagName, name: element.getAttribute('aria-label') ?? element.textContent, outline: style.outlineStyle, width: parseFloat(style.outlineWidth) };
});

// ---- checks ----

const checks = {
  async 'a run is drawn, whole and not blank'() {
    const opened = await open('run'), { view } = opened;
    await waitFrame(view, 30);
    const picture = await look(view, 'run');
    const cloth = measure(picture, isBlue), ball = measure(picture, isGrey), ground = measure(picture, isGround);
    assert.ok(cloth.share > 0.05 && cloth.share < 0.6, `cloth covers ${cloth.share}`);
    assert.ok(ball.share > 0.002, `the ball covers ${ball.share}`);
    assert.ok(ground.share > 0.3);
    assert.ok(cloth.left > 0.01 && cloth.right < 0.99 && cloth.top > 0.01 && cloth.bottom < 0.99, 'the cloth is cut off');
    assert.match(await view.getAttribute('aria-label'), /a <b>sheet<\/b> \(cloth, 441 vertices\), ball \(obstacle/);
    await close(opened);
  },

  async 'keys turn, play, go by frames'() {
    const opened = await open('run'), { page, view } = opened;
    await waitFrame(view, 30);
    const slider = page.getByRole('slider', { name: 'Frame' });
    const first = await look(view);
    await page.keyboard.press('Tab');
    let focus = await getFocus(page);
    assert.match(focus.name, /^Run run/);
    assert.ok(focus.outline === 'solid' && focus.width >= 2, 'the focus is not visible');
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('ArrowUp');
    await page.waitForTimeout(200);
    let turned = first;
    await until(async () => compare(first, (turned = await look(view))) > 0.01, 'arrows do not turn');
    await page.keyboard.press('+');
    await page.keyboard.press('+');
    const share = (picture) => measure(picture, isBlue).share;
    await until(async () => share(await look(view)) > 1.2 * share(turned), 'plus does not go nearer');
    await page.keyboard.press('Home');
    await until(async () => compare(first, await look(view)) < 0.02, 'Home does not show everything again');
    await page.keyboard.press('w');
    assert.equal(await page.getByRole('button', { name: 'Mesh' }).getAttribute('aria-pressed'), 'true');
    await until(async () => compare(first, await look(view, 'mesh')) > 0.01, 'the mesh is not drawn');
    await page.keyboard.press('w');
    await page.keyboard.press(',');
    await waitFrame(view, 29);
    assert.equal(await slider.inputValue(), '29');
    assert.equal(await slider.getAttribute('aria-valuetext'), 'frame 29 of 30, 0.64 s');
    await page.keyboard.press('.');
    await waitFrame(view, 30);
    await page.keyboard.press('Space');
    assert.equal(await page.getByRole('button', { name: 'Pause' }).count(), 1);
    await page.waitForFunction(() => Number(document.querySelector('input').value) > 8 && Number(document.querySelector('input').value) < 25);
    await page.keyboard.press('Space');
    const frame = Number(await slider.inputValue());
    assert.ok(frame < 30, 'play does not begin anew');
    await waitFrame(view, frame);
    await until(async () => compare(first, await look(view)) > 0.01, 'play does not change the picture');
    await page.waitForTimeout(200);
    assert.equal(Number(await slider.inputValue()), frame, 'it does not pause');
    await close(opened);
  },

  async 'controls are reached by Tab, and the slider scrubs'() {
    const opened = await open('run'), { page, view } = opened;
    await waitFrame(view, 30);
    const names = [];
    for (let k = 0; k < 5; k++) {
      await page.keyboard.press('Tab');
      const focus = await getFocus(page);
      names.push(focus.name);
      assert.ok(focus.outline === 'solid' && focus.width >= 2, `the focus is not visible at ${focus.name}`);
      if (focus.name === 'Frame') {
        const last = await look(view);
        await page.keyboard.press('Home');
        await waitFrame(view, 0);
        const start = await look(view, 'start');
        assert.ok(compare(last, start) > 0.03, 'the slider does not change the picture');
        await page.keyboard.press('ArrowRight');
        await waitFrame(view, 1);
        await page.keyboard.press('End');
        await waitFrame(view, 30);
        assert.ok(compare(last, await look(view)) < 0.001, 'a frame looks different the second time');
      }
    }
    assert.deepEqual(names.slice(1), ['Play', 'Frame', 'Mesh', 'Show everything']);
    await close(opened);
  },

  async 'a mouse turns, and the wheel goes nearer once the view has the focus'() {
    const opened = await open('run'), { page, view } = opened;
    await waitFrame(view, 30);
    const first = await look(view), share = (picture) => measure(picture, isBlue).share;
    await page.mouse.move(400, 200);
    await page.mouse.wheel(0, -300);
    await page.waitForTimeout(150);
    assert.ok(compare(first, await look(view)) < 0.001, 'the wheel zooms a view without the focus');
    await page.mouse.down();
    await page.mouse.move(520, 240, { steps: 4 });
    await page.mouse.up();
    let turned = first;
    await until(async () => compare(first, (turned = await look(view))) > 0.01, 'dragging does not turn');
    await page.mouse.wheel(0, -400);
    await until(async () => share(await look(view)) > 1.1 * share(turned), 'the wheel does not zoom');
    await close(opened);
  },

  async 'motion stops by itself where less of it is wanted'() {
    for (const reducedMotion of ['reduce', 'no-preference']) {
      const opened = await open('run', { reducedMotion }), { page, view } = opened;
      await waitFrame(view, 30);
      assert.equal(await page.getByRole('button', { name: 'Play' }).count(), 1, 'it plays without being asked');
      await page.getByRole('button', { name: 'Play' }).click();
      await page.waitForFunction(() => Number(document.querySelector('input').value) > 20);
      if (reducedMotion === 'reduce') {
        await page.getByRole('button', { name: 'Play' }).waitFor();
        assert.equal(await page.locator('input').inputValue(), '30');
      } else {
        await page.waitForFunction(() => Number(document.querySelector('input').value) < 15); // it begins anew
        assert.equal(await page.getByRole('button', { name: 'Pause' }).count(), 1);
      }
      await close(opened);
    }
  },

  async 'colors have a legend'() {
    const opened = await open('strain'), { page, view } = opened;
    await waitFrame(view, 30);
    const picture = await look(view, 'strain');
    const red = measure(picture, (r, g, b) => r > b + 25), blue = measure(picture, (r, g, b) => b > r + 25);
    assert.ok(red.share > 0.002 && blue.share > 0.002, 'there is no strain to see');
    assert.match(await page.locator('.legend').innerText(), /^strain \[%\]\s+\u2212(\d+(?:\.\d+)?)\s+\1$/);
    await close(opened);
  },

  async 'a thinned run says so'() {
    const opened = await open('thinned'), { page, view } = opened;
    await waitFrame(view);
    assert.match(await page.locator('.note').innerText(), /^\d+ of 31 frames are shown: the limit is 0\.04 MB/);
    await close(opened);
  },

  async 'edges of a box are sharp, and it is in the view'() {
    const opened = await open('box'), { page, view } = opened;
    await waitFrame(view);
    const picture = await look(view, 'box');
    const colors = new Map();
    for (let i = 0; i < picture.data.length; i += picture.channels) {
      const key = picture.data.slice(i, i + 3).map((part) => part >> 3).join();
      colors.set(key, (colors.get(key) ?? 0) + picture.channels / picture.data.length);
    }
    assert.ok([...colors.values()].filter((share) => share > 0.01).length >= 4, 'faces are not evenly shaded');
    const box = measure(picture, isBlue);
    assert.ok(box.left > 0.01 && box.right < 0.99 && box.top > 0.01 && box.bottom < 0.99 && box.share > 0.1, JSON.stringify(box));
    assert.equal(await page.getByRole('slider').count(), 0);
    await close(opened);
  },

  async 'a motion without times plays'() {
    const opened = await open('motion'), { page, view } = opened;
    await waitFrame(view, 4);
    assert.equal(await page.locator('.time').innerText(), '4 / 4');
    await page.getByRole('button', { name: 'Play' }).click();
    await page.waitForFunction(() => document.querySelector('input').value === '2');
    await close(opened);
  },

  async 'without WebGL there are words'() {
    const opened = await open('run', {}, (page) => page.addInitScript(() => {
      HTMLCanvasElement.prototype.getContext = () => null;
    }));
    await opened.page.locator('#text', { hasText: 'This browser cannot' }).waitFor();
    const text = await opened.page.locator('#text').innerText();
    assert.match(text, /a <b>sheet<\/b> \(cloth, 441 vertices\).*This browser cannot show it: it has no WebGL 2/);
    assert.equal(await opened.view.count(), 0);
    await close(opened);
    const still = await open('run', { javaScriptEnabled: false });
    assert.match(await still.page.locator('#text').innerText(), /^Run run, 31 frames/);
    await close(still);
  },

  async 'cells show views, wide and narrow'() {
    for (const width of [1100, 360]) {
      const opened = await open('cells', { viewport: { width, height: 1400 } }), { page } = opened;
      const frames = page.frames().slice(1);
      assert.equal(frames.length, 3);
      for (const frame of frames) {
        await waitFrame(frame.getByRole('application'));
        const { inner, outer } = await frame.evaluate(() => ({ inner: document.documentElement.scrollWidth, outer: innerWidth }));
        assert.ok(inner <= outer, `${inner} of ${outer} pixels`);
        const cut = await frame.evaluate(() => [...document.querySelectorAll('button, input, .legend, .time')].filter((each) => {
          const box = each.getBoundingClientRect();
          return box.width < 1 || box.left < 0 || box.right > innerWidth || box.bottom > innerHeight || each.scrollWidth > each.clientWidth + 1;
        }).map((each) => each.outerHTML));
        assert.deepEqual(cut, []);
        assert.equal(await frame.evaluate(() => origin), 'null', 'a view can reach the page around it');
      }
      for (const handle of await page.locator('iframe').all())
        await until(async () => measure(await look(handle), isGround).share < 0.95, 'a view is blank');
      await page.screenshot({ path: path.join(place, 'pages', `cells_${width}.png`), fullPage: true });
      await close(opened);
    }
  },

  async 'a page may hold more views than there are contexts'() {
    const opened = await open('many'), { page } = opened;
    const handles = await page.locator('iframe').all();
    for (const k of [...handles.keys(), 0, 12]) {
      await handles[k].scrollIntoViewIfNeeded();
      const frame = await (await handles[k].elementHandle()).contentFrame();
      await frame.waitForFunction(() => document.querySelector('canvas') && document.querySelector('.view')?.dataset.drawn, null, { timeout: 60000 });
      await until(async () => measure(await look(handles[k]), isBlue).share > 0.05, `view ${k} is blank`);
    }
    await close(opened);
  },

  async 'the page of a notebook shows its views'() {
    if (!fs.existsSync(path.join(place, 'pages/notebook.html'))) return 'skipped: nbconvert is missing';
    for (const width of [1200, 420]) {
      // The page asks for scripts of its own, which need not be there; views ask for nothing.
      const { page } = await open('notebook', { viewport: { width, height: 5200 }, offline: true });
      const frames = page.frames().slice(1);
      assert.equal(frames.length, 5);
      for (const frame of frames) await waitFrame(frame.getByRole('application'));
      for (const handle of await page.locator('iframe').all())
        await until(async () => measure(await look(handle), isGround).share < 0.97, 'a view is blank');
      await page.screenshot({ path: path.join(place, 'pages', `notebook_${width}.png`), fullPage: true });
      await page.context().close();
    }
  },
};

let failures = 0;
for (const [name, check] of Object.entries(checks)) {
  const start = Date.now();
  try {
    const word = await check();
    console.log(`${word ?? 'ok'}: ${name} (${((Date.now() - start) / 1000).toFixed(1)} s)`);
  } catch (problem) {
    failures++;
    console.log(`failed: ${name}\n${problem.stack}`);
  }
}
await browser.close();
console.log(`${Object.keys(checks).length - failures} of ${Object.keys(checks).length} checks of views passed`);
process.exit(failures ? 1 : 0);
