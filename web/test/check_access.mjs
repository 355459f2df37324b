// The page for everybody: rules of axe, keys, focus, small screens, little motion, no WebGL, a lost connection.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { close, getFrame, load, open, pictures, section, serve, until, waitFrame } from './harness.mjs';

const axe = fs.readFileSync(load.resolve('axe-core/axe.min.js'), 'utf8');

// What axe-core finds. It is put in by the debugger, which the policy of the page does not bind.
async function inspect(page, where) {
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() =>
    globalThis.axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa', 'wcag22aa', 'best-practice'] }),
  );
  const told = violations.map(
    ({ id, nodes }) =>
      `${id}: ${nodes
        .slice(0, 3)
        .map(({ html, failureSummary }) => `${html.slice(0, 160)} ${failureSummary}`)
        .join(' | ')}`,
  );
  assert.deepEqual(told, [], where);
}

const SIZES = [
  [1440, 900],
  [800, 600],
  [360, 740],
];
const shoot = (page, name) => page.screenshot({ path: path.join(pictures, `${name}.png`) });
const getFocus = (page) =>
  page.evaluate(() => {
    let element = document.activeElement;
    if (element?.shadowRoot?.activeElement) element = element.shadowRoot.activeElement;
    const style = getComputedStyle(element),
      tag = element.tagName.toLowerCase();
    return {
      name: element.getAttribute('aria-label') ?? element.closest('label')?.textContent ?? element.textContent,
      tag,
      width: parseFloat(style.outlineWidth),
      outline: style.outlineStyle,
    };
  });

// Nothing is wider than the window, and no control is cut off.
async function checkRoom(page, name) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(wide <= 0, `the page is ${wide} pixels wider than the window at ${name}`);
  const places = [
    'header button',
    '#editor button',
    '#editor select',
    'footer button',
    'footer input',
    'footer select',
    '.axes button',
  ];
  const cut = await page.evaluate(
    (selector) =>
      [...document.querySelectorAll(selector)]
        .filter((each) => {
          const box = each.getBoundingClientRect();
          return box.width > 0 && (box.left < 0 || box.right > innerWidth + 0.5 || box.bottom > innerHeight + 0.5);
        })
        .map((each) => each.outerHTML),
    places.join(),
  );
  assert.deepEqual(cut, [], `controls are cut off at ${name}`);
}

let run, live;

export const checks = {
  async 'for everybody: axe finds nothing, in light and dark, wide and narrow'() {
    run ??= await serve('watched');
    live ??= await serve('live.yaml');
    for (const colorScheme of ['light', 'dark'])
      for (const [width, height] of SIZES) {
        const opened = await open(run.address, { colorScheme, viewport: { width, height } }),
          { page, view } = opened,
          name = `${width}_${colorScheme}`;
        await waitFrame(view);
        if (width > 700) {
          await page.getByRole('button', { name: 'Plots' }).click();
          await page.getByLabel('Contacts', { exact: true }).check();
          await page.getByLabel('Strain along warp').check();
        }
        await page.getByRole('slider', { name: 'Frame' }).fill('36');
        await waitFrame(view, 36);
        await until(async () => (await view.getAttribute('data-coarse')) === null, 'the picture stays coarse');
        await shoot(page, `run_${name}`);
        await inspect(page, `a run, ${name}`);
        await checkRoom(page, name);
        if (width === 360) {
          await page.getByRole('button', { name: 'Panels', exact: true }).click();
          await page.getByLabel('Gaps').check();
          await page.waitForTimeout(400);
          await shoot(page, `sheet_${name}`);
          await inspect(page, `the panels as a sheet, ${name}`);
          await page.getByRole('button', { name: 'Close panels' }).click();
          await page.getByRole('button', { name: 'Play' }).click();
        }
        await close(opened);
        const held = await open(live.address, { colorScheme, viewport: { width, height } });
        await held.page.locator('.live-time[data-step]').waitFor();
        await held.page.getByRole('button', { name: 'Edit' }).click();
        await held.page.locator('.cm-line').first().waitFor();
        await held.page.waitForTimeout(300);
        await shoot(held.page, `live_${name}`);
        await checkRoom(held.page, `a live scene, ${name}`);
        await inspect(held.page, `a live scene with its text, ${name}`);
        if (width > 700) {
          await held.page.getByRole('application').focus();
          await held.page.keyboard.press('?');
          await held.page.getByRole('dialog').waitFor();
          await shoot(held.page, `keys_${name}`);
          await inspect(held.page, `the list of keys, ${name}`);
          await held.page.keyboard.press('Escape');
        }
        await close(held);
      }
  },

  async 'for everybody: Tab reaches everything in order, and the focus is seen'() {
    const opened = await open(run.address),
      { page, view } = opened,
      names = [];
    await waitFrame(view);
    for (let k = 0; k < 60; k++) {
      await page.keyboard.press('Tab');
      const focus = await getFocus(page);
      if (focus.tag === 'body') break;
      assert.ok(focus.outline !== 'none' && focus.width >= 2, `the focus is not seen at ${focus.name}`);
      names.push(focus.name.trim());
    }
    const order = [
      'Plots',
      'Panels',
      'Keys',
      'Run',
      'Frame all',
      'Look',
      'Shading',
      'Wireframe',
      'Overlays',
      'Contacts',
      'Selection',
      'Vertex',
      'Take away',
      'First frame',
      'Play',
      'Frame',
      'Speed',
    ];
    let place = 0;
    for (const wanted of order) {
      const found = names.findIndex((name, k) => k >= place && name.startsWith(wanted));
      assert.ok(found >= 0, `${wanted} is not reached after ${names[place - 1]}: ${names.join(', ')}`);
      place = found + 1;
    }
    await view.focus();
    await page.keyboard.press('?');
    const rows = await page.getByRole('dialog').getByRole('row').allInnerTexts();
    assert.ok(rows.length > 12 && rows.some((row) => /space/.test(row)));
    await page.keyboard.press('Escape');
    await page.keyboard.press('w');
    assert.ok(await page.getByLabel('Wireframe').isChecked());
    await page.keyboard.press(']');
    await until(
      async () => /frame 36/.test(await page.locator('#status').innerText()),
      'the live region does not tell the frame',
    );
    await close(opened);
  },

  async 'for everybody: where little motion is wanted, play stops at the end and views do not fly'() {
    const opened = await open(run.address, { reducedMotion: 'reduce' }),
      { page, view } = opened;
    await waitFrame(view);
    await page.getByLabel('Loop').check();
    await page.getByRole('combobox', { name: 'Speed', exact: true }).selectOption('8');
    await page.getByRole('button', { name: 'Play' }).click();
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await page.getByRole('button', { name: 'Play' }).waitFor();
    assert.equal(await getFrame(view), 36);
    await view.focus();
    await page.keyboard.press('3');
    await page.waitForTimeout(30);
    await until(() => /camera=/.test(page.url()), 'the address does not tell the camera');
    await close(opened);
  },

  async 'for everybody: without WebGL there are numbers'() {
    const prepare = (page) =>
      page.addInitScript(() => {
        const get = HTMLCanvasElement.prototype.getContext;
        HTMLCanvasElement.prototype.getContext = function getContext(kind, ...rest) {
          return /webgl/.test(kind) ? null : get.call(this, kind, ...rest);
        };
      });
    const opened = await open(run.address, { prepare }),
      { page } = opened;
    await page.getByText('This browser cannot draw').waitFor();
    await page.getByText('cloth, 625 vertices, 1152 triangles').waitFor();
    await page.getByRole('slider', { name: 'Frame' }).fill('20');
    await until(
      async () => /Frame\s+20/.test(await page.locator('#numbers').innerText()),
      'the numbers do not follow the timeline',
    );
    await inspect(page, 'numbers');
    await close(opened);
    const held = await open(live.address, { prepare });
    await held.page.getByRole('button', { name: 'Start' }).click();
    await until(async () => /kinetic energy/.test(await held.page.locator('#numbers').innerText()), 'energies are not told');
    await held.page.getByRole('button', { name: 'Pause' }).click();
    await close(held);
  },

  async 'for everybody: a lost connection is told, and made again'() {
    let toPage = null,
      isCut = false;
    const prepare = (page) =>
      page.routeWebSocket(/\/session$/, (socket) => {
        if (isCut) return socket.close({ code: 1001 });
        toPage = socket;
        return socket.connectToServer();
      });
    const opened = await open(run.address, { prepare }),
      { page, view } = opened;
    await waitFrame(view);
    await page.getByRole('slider', { name: 'Frame' }).fill('12');
    await waitFrame(view, 12);
    isCut = true;
    await toPage.close({ code: 1001, reason: 'gone' });
    await until(
      async () => /lost/i.test(await page.locator('#link-state').innerText()),
      'nothing says that the connection is lost',
    );
    assert.match(await page.locator('#status').innerText(), /connection is lost/);
    await shoot(page, 'lost');
    isCut = false;
    await until(async () => (await page.locator('#link-state').innerText()) === 'Connected', 'it is not made again', 25000);
    await page.getByRole('slider', { name: 'Frame' }).fill('30');
    await waitFrame(view, 30);
    assert.ok(await section(page, 'Look').isVisible());
    await close(opened, { expected: ['WebSocket'] });
    await run.stop();
    await live.stop();
  },
};
