// Holding a live scene: start and stop, grab, cut, move, change, and what repeats it.
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {
  close,
  compare,
  differs,
  look,
  open,
  openSection,
  readFacts,
  section,
  serve,
  settle,
  toNumber,
  toNumbers,
  tulle,
  until,
  work,
} from './harness.mjs';

let server, opened;
const hold = (page) => section(page, 'Hold');
const readStep = async (page) => Number(await page.locator('.live-time').getAttribute('data-step'));
const isPaused = async (page) => /paused/.test(await page.locator('.live-time').innerText());

// One scene is held through all of these checks; each begins it anew.
const visit = async () => {
  server ??= await serve('live.yaml', '--threads', '1');
  if (!opened || opened.page.isClosed()) opened = await open(server.address);
  const { page } = opened;
  await page.locator('.live-time[data-step]').waitFor();
  // What the last check did may still be on its way.
  await until(async () => {
    if (await isPaused(page)) return true;
    await page.locator('button[aria-label=Pause]').evaluateAll((buttons) => buttons.forEach((button) => button.click()));
    await page.waitForTimeout(200);
    return false;
  }, 'it does not pause');
  await page.getByRole('button', { name: 'Reset' }).click();
  await until(async () => (await readStep(page)) === 0, 'reset does not lead to step 0');
  await hold(page).getByRole('button', { name: 'Look', exact: true }).click();
  await page.getByRole('button', { name: 'Frame all' }).click();
  return opened;
};

const choose = async (page, object, vertex) => {
  const panel = section(page, 'Selection');
  await panel.getByLabel('Object', { exact: true }).selectOption({ label: object });
  await panel.getByLabel('Vertex', { exact: true }).fill(String(vertex));
  await panel.getByRole('button', { name: 'Choose' }).click();
};
// Where a vertex is, as the server tells.
const readVertex = async (page, object, vertex) => {
  await page.keyboard.press('Escape');
  await choose(page, object, vertex);
  return until(async () => {
    const facts = await readFacts(page).catch(() => ({}));
    return facts.Vertex === String(vertex) && { ...facts, position: toNumbers(facts['Position [m]']) };
  }, `vertex ${vertex} of ${object} is not told`);
};
const step = async (page, count) => {
  const before = await readStep(page);
  for (let made = 0; made < count;) {
    const now = count - made >= 10 ? 10 : 1;
    await page.keyboard.press(now === 10 ? '>' : '.');
    made += now;
    await until(async () => (await readStep(page)) === before + made, `${count} steps are not made`);
  }
};
const distance = (a, b) => Math.hypot(...a.map((part, k) => part - b[k]));
const BOTTOM = 152; // the vertex in the middle of the lower edge

export const checks = {
  async 'holding: start, pause, step, reset, rewind'() {
    const { page, view } = await visit();
    assert.equal(await page.locator('#kind').textContent(), 'live scene');
    await page.getByRole('button', { name: 'Start' }).click();
    await until(async () => (await readStep(page)) > 30, 'it does not run');
    await page.getByRole('button', { name: 'Pause' }).click();
    await until(() => isPaused(page), 'it does not pause');
    const stopped = await readStep(page);
    await page.waitForTimeout(300);
    assert.equal(await readStep(page), stopped);
    await page.getByRole('button', { name: 'Step', exact: true }).click();
    await until(async () => (await readStep(page)) === stopped + 1, 'it does not make one step');
    await view.focus();
    await page.keyboard.press('.');
    await until(async () => (await readStep(page)) === stopped + 2, 'the full stop does not make a step');
    const rewind = page.getByLabel('Rewind to');
    const saved = await until(async () => {
      const values = await rewind.locator('option').evaluateAll((options) =>
        options
          .map(({ value }) => value)
          .filter(Boolean)
          .map(Number),
      );
      return values.find((value) => value < stopped && value > 0) ?? (values.length ? values[0] : null) ?? false;
    }, 'no state is saved').then(Number);
    await rewind.selectOption(String(saved));
    await until(async () => (await readStep(page)) === saved, 'rewind does not go there');
    await page.keyboard.press('Space');
    await until(async () => !(await isPaused(page)), 'space does not start');
    await page.getByRole('button', { name: 'Pause' }).click();
    await view.focus();
    await page.keyboard.press('r');
    await until(async () => (await readStep(page)) === 0, 'R does not reset');
  },

  async 'holding: cloth is pulled by the mouse, with a limited force'() {
    const { page } = await visit();
    await lookFromBehind(page);
    const before = (await readVertex(page, 'curtain', BOTTOM)).position;
    // Where that vertex is in the picture: the magenta mark.
    const mark = await findMark(page);
    await hold(page).getByRole('button', { name: 'Grab', exact: true }).click();
    await hold(page).getByLabel('Force [N], as a number').fill('20');
    await hold(page).getByLabel('Force [N], as a number').press('Enter');
    await page.mouse.move(mark.x, mark.y - 3);
    await page.mouse.down();
    await page.getByRole('button', { name: 'Start' }).evaluate((button) => button.click());
    await page.mouse.move(mark.x + 60, mark.y - 80, { steps: 12 });
    await page.waitForTimeout(600);
    await look(page, 'grab');
    await page.mouse.move(mark.x + 110, mark.y - 120, { steps: 12 });
    await page.waitForTimeout(900);
    await page.locator('button[aria-label=Pause]').evaluate((button) => button.click());
    await until(() => isPaused(page), 'it does not pause');
    const pulled = (await readVertexQuietly(page)).position;
    assert.ok(distance(before, pulled) > 0.1, `the vertex went from ${before} to ${pulled}`);
    await page.mouse.up();
    assert.match(await page.locator('#status').innerText(), /let go/);
    await page.getByRole('button', { name: 'Start' }).click();
    await until(async () => {
      await page.waitForTimeout(300);
      return distance((await readVertexQuietly(page)).position, before) < 0.6 * distance(pulled, before);
    }, 'it does not swing back');
    await page.getByRole('button', { name: 'Pause' }).click();
  },

  async 'holding: a finger pulls, too'() {
    const { page } = await visit();
    await lookFromBehind(page);
    const before = (await readVertex(page, 'curtain', BOTTOM)).position,
      mark = await findMark(page);
    await hold(page).getByRole('button', { name: 'Grab', exact: true }).click();
    await page.getByRole('button', { name: 'Start' }).click();
    // A finger that Chromium knows of, so that it can be captured.
    const client = await page.context().newCDPSession(page),
      send = (type, x, y) =>
        client.send('Input.dispatchTouchEvent', { type, touchPoints: type === 'touchEnd' ? [] : [{ x, y }] });
    await send('touchStart', mark.x, mark.y - 3);
    for (let k = 1; k <= 10; k++) await send('touchMove', mark.x + 9 * k, mark.y - 9 * k);
    await page.waitForTimeout(800);
    await page.locator('button[aria-label=Pause]').evaluate((button) => button.click());
    await until(() => isPaused(page), 'it does not pause');
    assert.ok(distance((await readVertexQuietly(page)).position, before) > 0.05, 'the cloth does not follow the finger');
    await send('touchEnd');
    await until(async () => /let go/.test(await page.locator('#status').innerText()), 'the finger does not let go');
  },

  async 'holding: cloth is pulled by keys'() {
    const { page, view } = await visit(),
      before = (await readVertex(page, 'curtain', BOTTOM)).position;
    await section(page, 'Selection').getByRole('button', { name: 'Hold here' }).click();
    await page.locator('#hint', { hasText: 'Arrow keys' }).waitFor();
    assert.ok(await view.evaluate((element) => element === document.activeElement), 'the picture has not the focus');
    await page.keyboard.press('Space');
    for (let k = 0; k < 8; k++) {
      await page.keyboard.press('ArrowUp');
      await page.keyboard.press('PageDown');
    }
    await page.waitForTimeout(1200);
    await page.keyboard.press('Space');
    await until(() => isPaused(page), 'it does not pause');
    const held = await readVertexQuietly(page);
    assert.ok(distance(held.position, before) > 0.05, `keys do not pull: ${before}, ${held.position}`);
    await section(page, 'Selection').getByRole('button', { name: 'Left', exact: true }).click();
    await view.focus();
    await page.keyboard.press('Enter');
    await until(async () => /let go/.test(await page.locator('#status').innerText()), 'Enter does not let go');
    assert.ok(await page.locator('#hint').isHidden());
  },

  async 'holding: a pin is cut'() {
    const { page } = await visit();
    await hold(page).getByRole('button', { name: 'Cut pins' }).click();
    await settle(page);
    const pinned = await until(async () => {
      for (const vertex of [136, 0, 272]) if ((await readVertex(page, 'curtain', vertex)).Pin === 'pinned') return vertex;
      return false;
    }, 'no vertex is pinned');
    const before = await readVertex(page, 'curtain', pinned);
    await section(page, 'Selection').getByRole('button', { name: 'Cut pin' }).click();
    await until(async () => /is cut/.test(await page.locator('#status').innerText()), 'nothing says that the pin is cut');
    await opened.view.focus();
    await step(page, 30);
    const after = await readVertex(page, 'curtain', pinned);
    assert.ok(
      distance(before.position, after.position) > 0.005,
      `a vertex whose pin is cut stays: ${before.position}, ${after.position}`,
    );
  },

  async 'holding: an obstacle is moved by numbers and by its arrows'() {
    const { page } = await visit();
    await choose(page, 'block', 0);
    await hold(page).getByRole('button', { name: 'Move', exact: true }).click();
    const before = (await readVertex(page, 'block', 0)).position;
    await hold(page).getByLabel('Middle [m] x').fill('0.5');
    await hold(page).getByRole('button', { name: 'Move there' }).click();
    await opened.view.focus();
    await step(page, 60);
    const after = (await readVertex(page, 'block', 0)).position;
    assert.ok(Math.abs(after[0] - before[0] + 0.3) < 0.02, `${before} to ${after}`);
    await page.getByRole('button', { name: 'View along Y' }).click();
    await settle(page);
    const arrow = await findArrow(page);
    await page.mouse.move(arrow.x, arrow.y);
    await page.mouse.down();
    await page.mouse.move(arrow.x + 50, arrow.y, { steps: 10 });
    await page.mouse.up();
    await opened.view.focus();
    await step(page, 40);
    const dragged = (await readVertex(page, 'block', 0)).position;
    assert.ok(dragged[0] - after[0] > 0.03 && Math.abs(dragged[2] - after[2]) < 0.02, `${after} to ${dragged}`);
    await look(page, 'move');
  },

  async 'holding: a body is moved, cloth is not'() {
    const { page } = await visit(),
      before = (await readVertex(page, 'ball', 0)).position;
    await choose(page, 'ball', 0);
    await hold(page).getByRole('button', { name: 'Move', exact: true }).click();
    await hold(page).getByLabel('Middle [m] z').fill('0.5');
    await hold(page).getByRole('button', { name: 'Move there' }).click();
    await opened.view.focus();
    await step(page, 60);
    assert.ok((await readVertex(page, 'ball', 0)).position[2] - before[2] > 0.1, 'the ball does not rise');
    await choose(page, 'curtain', 0);
    await hold(page).getByRole('button', { name: 'Move', exact: true }).click();
    await until(
      async () => /choose an obstacle or a body/.test(await page.locator('#status').innerText()),
      'cloth is offered to be moved',
    );
    assert.equal(await hold(page).getByRole('button', { name: 'Move there' }).count(), 0);
  },

  async 'holding: wind, gravity, fabric and friction change while it runs'() {
    const { page } = await visit(),
      scene = await openSection(page, 'Scene');
    const type = async (name, value) => {
      await scene.getByLabel(`${name}, as a number`).fill(String(value));
      await scene.getByLabel(`${name}, as a number`).press('Enter');
    };
    const before = (await readVertex(page, 'curtain', BOTTOM)).position;
    await type('Wind x', 8);
    await page.waitForTimeout(200);
    await opened.view.focus();
    await step(page, 30);
    const blown = (await readVertex(page, 'curtain', BOTTOM)).position;
    assert.ok(blown[0] - before[0] > 0.02, `wind does nothing: ${before}, ${blown}`);
    await type('Wind x', 0);
    await type('Gravity z', 9.81);
    await page.waitForTimeout(200);
    await opened.view.focus();
    await step(page, 40);
    const risen = (await readVertex(page, 'curtain', BOTTOM)).position;
    assert.ok(risen[2] > before[2] + 0.05, `gravity that points upwards does nothing: ${before}, ${risen}`);
    await scene.getByLabel('curtain', { exact: true }).first().selectOption('denim');
    await type('curtain', 0.9);
    await page.waitForTimeout(200);
    assert.equal(await page.locator('#notes').innerText(), '', 'the server refuses a change');
    // Silk would be lighter: the server tells the masses of denim now.
    const mass = toNumber((await readVertex(page, 'curtain', BOTTOM))['Mass [kg]']);
    assert.ok(mass > 0);
  },

  async 'holding: the recording repeats it bit for bit, the session too'() {
    const { page } = await visit();
    await (await openSection(page, 'Scene')).getByLabel('Wind y, as a number').fill('4');
    await section(page, 'Scene').getByLabel('Wind y, as a number').press('Enter');
    await choose(page, 'curtain', BOTTOM);
    await section(page, 'Selection').getByRole('button', { name: 'Hold here' }).click();
    for (let k = 0; k < 4; k++) await page.keyboard.press('ArrowRight');
    await page.waitForTimeout(300);
    await step(page, 30);
    await page.keyboard.press('Enter');
    await page.waitForTimeout(200);
    await step(page, 10);
    const take = await openSection(page, 'Take away');
    const [file] = await Promise.all([page.waitForEvent('download'), take.getByRole('button', { name: 'Recording' }).click()]);
    const recording = path.join(work, 'recording.tulle');
    await file.saveAs(recording);
    for (const threads of ['1', '2']) {
      const { status, stdout, stderr } = spawnSync(tulle, ['replay', recording, '--threads', threads], { encoding: 'utf8' });
      assert.equal(status, 0, `${stdout}${stderr}`);
    }
    const last = (await readVertex(page, 'curtain', BOTTOM)).position;
    await take.getByRole('button', { name: 'Save session' }).click();
    await until(() => fs.readdirSync(work).some((name) => name.endsWith('.session')), 'no session is saved');
    const session = fs.readdirSync(work).find((name) => name.endsWith('.session'));
    const again = await serve('live.yaml', '--replay', session, '--threads', '2'),
      other = await open(again.address);
    await other.page.locator('.live-time[data-step]').waitFor();
    await until(async () => (await readStep(other.page)) >= 40, 'the session does not come to its end');
    await until(() => isPaused(other.page), 'the session does not stand still at its end');
    assert.equal(await readStep(other.page), await readStep(page));
    const repeated = (await readVertex(other.page, 'curtain', BOTTOM)).position;
    assert.deepEqual(repeated, last, 'the session leads elsewhere');
    await close(other);
    await again.stop();
  },

  async 'holding: two pages see the same scene'() {
    const { page } = await visit(),
      other = await open(server.address);
    await other.page.locator('.live-time[data-step]').waitFor();
    await opened.view.focus();
    await step(page, 12);
    await until(async () => (await readStep(other.page)) === 12, 'the other page stays behind');
    const before = await settle(other.page);
    await page.getByRole('button', { name: 'Start' }).click();
    await differs(other.page, before, 0.001, 'the other page does not draw what goes on');
    await other.page.getByRole('button', { name: 'Pause' }).click();
    await until(() => isPaused(page), 'a pause of one page does not hold for the other');
    assert.ok(compare(before, before) === 0);
    await close(other);
    await close(opened);
    await server.stop();
  },
};

// From where nothing stands before the curtain.
async function lookFromBehind(page) {
  for (let k = 0; k < 2; k++) {
    await page.getByRole('button', { name: 'View along X' }).click();
    await settle(page);
  }
}

// As readVertex, of what is chosen already, without keys or clicks that would let go.
async function readVertexQuietly(page) {
  await section(page, 'Selection')
    .getByRole('button', { name: 'Vertex', exact: true })
    .evaluate((button) => button.click());
  await page.waitForTimeout(150);
  return until(async () => {
    const facts = await readFacts(page).catch(() => ({}));
    return facts['Position [m]'] && facts.Vertex && { position: toNumbers(facts['Position [m]']) };
  }, 'the chosen vertex is not told');
}

// The middle of the pixels of a color in the picture, in coordinates of the page; of those at its right end where `isRight`.
async function findPixels(page, test, isRight = false) {
  const { width, height, channels, data } = await look(page),
    box = await page.locator('#stage').boundingBox();
  let found = [];
  for (let i = 0; i < width * height; i++)
    if (test(data[channels * i], data[channels * i + 1], data[channels * i + 2]))
      found.push([i % width, Math.floor(i / width)]);
  assert.ok(found.length > 0, 'the mark is not in the picture');
  const end = Math.max(...found.map(([x]) => x));
  if (isRight) found = found.filter(([x]) => x > end - 10);
  const [x, y] = [0, 1].map((axis) => found.reduce((sum, point) => sum + point[axis], 0) / found.length);
  return { x: box.x + x, y: box.y + y };
}

const findMark = (page) => findPixels(page, (r, g, b) => r > 240 && g > 40 && g < 90 && b > 100 && b < 150);
const findArrow = (page) => findPixels(page, (r, g, b) => r > 235 && g < 25 && b < 25, true);
