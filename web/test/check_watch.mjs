// Watching a run: the view, its looks, the timeline, overlays, plots, picking, what one takes away.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import {
  close,
  compare,
  differs,
  getFrame,
  look,
  measure,
  open,
  openSection,
  readFacts,
  readPc2,
  readPng,
  section,
  serve,
  settle,
  toNumber,
  toNumbers,
  tulle,
  until,
  waitFrame,
  work,
} from './harness.mjs';

const isBackground = (r, g, b) => Math.abs(r - 238) < 6 && Math.abs(g - 241) < 6 && Math.abs(b - 244) < 6;
const isCloth = (r, g, b) => r > g + 25 && r > b + 25;
const LAST = 36; // frame of the run `watched`

let server;
const visit = async (fragment, options = {}) => {
  server ??= await serve('watched');
  const opened = await open(server.address, { fragment, ...options });
  await waitFrame(opened.view);
  return opened;
};
const slider = (page) => page.getByRole('slider', { name: 'Frame' });
const go = async ({ page, view }, frame) => {
  await slider(page).fill(String(frame));
  await waitFrame(view, frame);
};

export const checks = {
  async 'watching: a run is drawn and no request leaves the page'() {
    const opened = await visit(),
      { page, view } = opened;
    await go(opened, LAST);
    const picture = await settle(page),
      cloth = measure(picture, isCloth);
    assert.ok(cloth > 0.05 && cloth < 0.7, `cloth covers ${cloth}`);
    assert.ok(measure(picture, isBackground) > 0.1);
    assert.match(await view.getAttribute('aria-label'), /^Run .*: sheet \(cloth, 1152 triangles\), ball \(obstacle/);
    assert.equal(await page.locator('#link-state').textContent(), 'Connected');
    const policy = await (await fetch(server.address)).headers.get('content-security-policy');
    assert.ok(/default-src 'none'/.test(policy) && !/unsafe/.test(policy), policy);
    await close(opened);
  },

  async 'watching: keys and mouse turn, move, zoom and frame'() {
    const opened = await visit(),
      { page, view } = opened;
    await go(opened, LAST);
    let before = await settle(page);
    const first = before,
      share = (picture) => measure(picture, isCloth);
    await view.focus();
    for (const key of ['ArrowLeft', 'ArrowUp', 'Shift+ArrowRight']) {
      await page.keyboard.press(key);
      before = await differs(page, before, 0.01, `${key} does nothing`);
    }
    for (let k = 0; k < 3; k++) await page.keyboard.press('+');
    await until(async () => share(await look(page)) > 1.2 * share(before), 'plus does not go nearer');
    for (const key of ['1', '2', '3']) {
      before = await settle(page);
      await page.keyboard.press(key);
      await differs(page, before, 0.01, `the view along axis ${key} is the same`);
    }
    await page.keyboard.press('Home');
    const framed = await settle(page);
    assert.ok(share(framed) > 0.05);
    const box = await page.locator('#view').boundingBox(),
      x = box.x + box.width / 2,
      y = box.y + box.height / 2;
    const drag = async (button, message) => {
      before = await settle(page);
      await page.mouse.move(x, y);
      await page.mouse.down({ button });
      await page.mouse.move(x + 90, y + 40, { steps: 5 });
      await page.mouse.up({ button });
      await differs(page, before, 0.01, message);
    };
    await drag('left', 'dragging does not turn');
    await drag('right', 'dragging with the right button does not move');
    before = await settle(page);
    await page.mouse.wheel(0, -400);
    await until(async () => share(await look(page)) > 1.1 * share(before), 'the wheel does not zoom');
    await page.getByRole('button', { name: 'View along X' }).click();
    const side = await settle(page);
    await page.getByRole('button', { name: 'View along X' }).click();
    await differs(page, side, 0.001, 'the second press does not turn to the other side');
    await page.getByRole('button', { name: 'Frame all' }).click();
    assert.ok(compare(first, await settle(page)) > 0.01, 'the view along an axis is kept');
    await close(opened);
  },

  async 'watching: shading, wires, checks, shadows and ground'() {
    const opened = await visit(),
      { page } = opened;
    await go(opened, LAST);
    const first = await settle(page),
      looks = await openSection(page, 'Look');
    const turns = [
      [
        'flat shading',
        () => looks.getByLabel('Shading').selectOption('flat'),
        () => looks.getByLabel('Shading').selectOption('smooth'),
        0.003,
      ],
      [
        'checks',
        () => looks.getByLabel('Texture').selectOption('checker'),
        () => looks.getByLabel('Texture').selectOption('plain'),
        0.02,
      ],
      ...['Wireframe', 'Shadows', 'Ground'].map((name) => [
        name,
        () => looks.getByLabel(name).click(),
        () => looks.getByLabel(name).click(),
        0.002,
      ]),
    ];
    for (const [name, on, off, share] of turns) {
      await on();
      await differs(page, first, share, `${name} changes nothing`);
      await off();
      await until(async () => compare(first, await look(page)) < 0.001, `${name} does not go away again`);
    }
    await close(opened);
  },

  async 'watching: the timeline by keys, buttons and pointer'() {
    const opened = await visit(),
      { page, view } = opened;
    await waitFrame(view, 0);
    const start = await settle(page);
    await slider(page).focus();
    await page.keyboard.press('End');
    await waitFrame(view, LAST);
    await differs(page, start, 0.01, 'the last frame looks like the first');
    await page.keyboard.press('ArrowLeft');
    await waitFrame(view, LAST - 1);
    assert.match(await slider(page).getAttribute('aria-valuetext'), /^frame 35 of 36, 1\.17 s$/);
    for (const [key, frame] of [
      [',', 34],
      ['.', 35],
      ['[', 0],
      [']', LAST],
    ]) {
      await page.keyboard.press(key);
      await waitFrame(view, frame);
    }
    await page.getByRole('button', { name: 'First frame' }).click();
    await waitFrame(view, 0);
    assert.ok(compare(start, await settle(page)) < 0.001, 'a frame looks different the second time');
    const box = await slider(page).boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await until(async () => Math.abs((await getFrame(view)) - LAST / 2) <= 1, 'a click into the slider does not go there');
    await close(opened);
  },

  async 'watching: play at speed, loop, and stop at the end'() {
    const opened = await visit(),
      { page, view } = opened;
    await view.focus();
    await page.keyboard.press('Space');
    await page.getByRole('button', { name: 'Pause' }).waitFor();
    await until(async () => (await getFrame(view)) > 3, 'it does not play');
    await page.keyboard.press('Space');
    const frame = Number(await slider(page).inputValue());
    await page.waitForTimeout(300);
    assert.equal(Number(await slider(page).inputValue()), frame, 'it does not pause');
    await page.getByRole('combobox', { name: 'Speed', exact: true }).selectOption('8');
    await page.getByRole('button', { name: 'Play' }).click();
    await waitFrame(view, LAST);
    await page.getByRole('button', { name: 'Play' }).waitFor();
    await page.getByLabel('Loop').check();
    await page.getByRole('combobox', { name: 'Speed', exact: true }).selectOption('1');
    await go(opened, LAST - 6);
    await page.getByRole('button', { name: 'Play' }).click();
    await until(async () => (await getFrame(view)) < LAST / 2, 'it does not begin anew');
    await close(opened);
  },

  async 'watching: scrubbing over ten thousand frames shows the newest, in bounded memory'() {
    const { address, stop } = await serve('long'),
      opened = await open(address),
      { page, view } = opened;
    await waitFrame(view);
    assert.equal(await slider(page).getAttribute('max'), '9999');
    const box = await slider(page).boundingBox();
    await page.mouse.move(box.x + 10, box.y + 10);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width - 40, box.y + 10, { steps: 60 });
    await page.mouse.up();
    const wanted = Number(await slider(page).inputValue());
    assert.ok(wanted > 8500, `the slider is at ${wanted}`);
    await waitFrame(view, wanted);
    const pc2 = readPc2(path.join(work, 'long/flag.pc2'));
    for (const frame of [9999, 1, 7777, 5000]) {
      await go(opened, frame);
      await section(page, 'Selection').getByLabel('Vertex', { exact: true }).fill('20');
      await section(page, 'Selection').getByRole('button', { name: 'Choose' }).click();
      const exact = pc2.get(frame, 20);
      await until(async () => {
        const facts = await readFacts(page).catch(() => ({}));
        return (
          facts.Frame === String(frame) && toNumbers(facts['Position [m]']).every((part, k) => Math.abs(part - exact[k]) < 1e-6)
        );
      }, `frame ${frame} is not that of the run`);
    }
    // A message for each frame would be ten thousand; memory holds what is near.
    await page.getByRole('combobox', { name: 'Speed', exact: true }).selectOption('8');
    await go(opened, 0);
    await page.getByRole('button', { name: 'Play' }).click();
    await until(async () => (await getFrame(view)) > 1500, 'it does not play at eight times the speed');
    await page.getByRole('button', { name: 'Pause' }).click();
    await close(opened);
    await stop();
  },

  async 'watching: a run under way is followed'() {
    fs.writeFileSync(
      path.join(work, 'slow.yaml'),
      fs.readFileSync(path.join(work, 'watched.yaml'), 'utf8').replace('1.2 s', '60 s').replace('[25, 25]', '[31, 31]'),
    );
    const child = spawn(tulle, ['run', 'slow.yaml', '-o', 'slow'], { cwd: work, stdio: 'ignore' });
    try {
      await until(
        () => fs.existsSync(path.join(work, 'slow/run.json')) && fs.existsSync(path.join(work, 'slow/sheet.pc2')),
        'the run does not begin',
      );
      await new Promise((done) => setTimeout(done, 1500));
      const { address, stop } = await serve('slow'),
        opened = await open(address),
        { page, view } = opened;
      await waitFrame(view);
      await page.getByLabel('Follow').check();
      const first = await getFrame(view);
      await until(async () => (await getFrame(view)) > first + 5, 'new frames do not come');
      assert.equal(Number(await slider(page).inputValue()), Number(await slider(page).getAttribute('max')));
      await close(opened);
      await stop();
    } finally {
      child.kill('SIGINT');
      await new Promise((done) => child.on('exit', done));
    }
  },

  async 'watching: overlays have legends, and tell what the report tells'() {
    const opened = await visit(),
      { page } = opened;
    await go(opened, LAST);
    const plain = await settle(page),
      overlays = await openSection(page, 'Overlays'),
      legends = page.locator('.legends');
    // The line of report.csv behind the step of the last frame.
    const lines = fs
      .readFileSync(path.join(work, 'watched/report.csv'), 'utf8')
      .trim()
      .split('\n')
      .map((line) => line.split(','));
    const report = Object.fromEntries(lines[0].map((name, k) => [name, lines[3 * LAST][k]]));
    await overlays.getByLabel('Contacts', { exact: true }).check();
    await until(
      async () => (await legends.innerText()).includes(`${report.stick_contacts} stick`),
      'the legend does not tell the contacts that stick',
    );
    assert.match(await legends.innerText(), new RegExp(`${report.slip_contacts} slip`));
    await differs(page, plain, 0.001, 'contacts are not drawn');
    await overlays.getByLabel('Contacts', { exact: true }).uncheck();
    const expected = {
      'Contact normals': /contact normals/,
      Impulses: /the longest [\d.e\u2212]+ N s/,
      Velocities: /the fastest vertex [\d.]+ m\/s/,
      Patches: /\d+ patches/,
      Gaps: /Gap \[mm\][\s\S]*the smallest/,
      'Strain along warp': /Strain along warp \[%\]/,
      'Strain along weft': /largest now/,
      'Shear strain': /hatched: negative/,
    };
    for (const [name, words] of Object.entries(expected)) {
      const box = overlays.getByLabel(name, { exact: true });
      await box.check();
      await until(
        async () => words.test(await legends.innerText()),
        `the legend of ${name} does not come: ${await legends.innerText()}`,
      );
      await differs(page, plain, 0.001, `${name} is not drawn`);
      await box.uncheck();
      await until(async () => !words.test(await legends.innerText()), `the legend of ${name} stays`);
    }
    await overlays.getByLabel('Crossing pairs').check();
    await until(async () => /The judge finds none/.test(await legends.innerText()), 'the judge does not answer');
    // Of those that color surfaces one is on at a time.
    await overlays.getByLabel('Gaps').check();
    await overlays.getByLabel('Patches').check();
    assert.equal(await overlays.getByLabel('Gaps').isChecked(), false);
    await close(opened);
  },

  async 'watching: crossing pairs of a mesh are outlined'() {
    fs.writeFileSync(
      path.join(work, 'crossed.obj'),
      'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 -0.5\nv 0.3 0.2 0.5\nv 0.2 0.4 0.5\nf 1 2 3\nf 4 5 6\n',
    );
    const { address, stop } = await serve('crossed.obj'),
      opened = await open(address),
      { page } = opened;
    await waitFrame(opened.view);
    await (await openSection(page, 'Overlays')).getByLabel('Crossing pairs').check();
    await until(
      async () => /1 pairs?, outlined in red/.test(await page.locator('.legends').innerText()),
      'the pair is not found',
    );
    await until(
      async () => measure(await look(page), (r, g, b) => r > 180 && g < 60 && b < 90) > 0.0005,
      'the pair is not drawn',
    );
    await close(opened);
    await stop();
  },

  async 'watching: plots go along with the timeline'() {
    const opened = await visit(),
      { page, view } = opened;
    await page.getByRole('button', { name: 'Plots' }).click();
    const plot = page.locator('canvas.plot'),
      lines = fs
        .readFileSync(path.join(work, 'watched/report.csv'), 'utf8')
        .trim()
        .split('\n')
        .map((line) => line.split(','));
    await go(opened, 30);
    await page.getByRole('combobox', { name: 'Plot' }).selectOption('contacts');
    const column = lines[0].indexOf('contacts');
    await until(
      async () => {
        const label = await plot.getAttribute('aria-label'),
          told = /at step 90: contacts ([\d.]+)/.exec(label)?.[1];
        // A bucket begins at this step or a little before it.
        return told !== undefined && lines.slice(86, 92).some((line) => Number(line[column]) === Number(told));
      },
      `the plot does not tell the contacts of step 90: ${await plot.getAttribute('aria-label')}`,
    );
    for (const [group, label] of [
      ['energy', 'Energy'],
      ['solve', 'Solve'],
      ['times', 'Stage times'],
    ]) {
      await page.getByRole('combobox', { name: 'Plot' }).selectOption(group);
      await until(async () => {
        const told = await plot.getAttribute('aria-label');
        return told.startsWith(label) && !/\u2013(,|$)/.test(told);
      }, `the plot ${group} has no values`);
    }
    const box = await plot.boundingBox();
    await plot.click({ position: { x: 52 + (box.width - 56) * 0.5, y: 40 } });
    await until(async () => Math.abs((await getFrame(view)) - LAST / 2) <= 1, 'a click into the plot does not go there');
    await close(opened);
  },

  async 'watching: picking tells about a vertex, an edge and a triangle'() {
    const opened = await visit(),
      { page } = opened;
    await go(opened, LAST);
    await settle(page);
    const box = await page.locator('#view').boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + box.height * 0.45);
    const panel = section(page, 'Selection');
    await panel.getByRole('button', { name: 'Vertex' }).click();
    await until(
      async () =>
        (await readFacts(page).catch(() => ({})))['Mass [kg]'] !== undefined ||
        (await readFacts(page).catch(() => ({})))['Vertex'] !== undefined,
      'nothing is told',
    );
    const vertex = await readFacts(page),
      pc2 = readPc2(path.join(work, 'watched/sheet.pc2')),
      exact = pc2.get(LAST, Number(vertex.Vertex));
    toNumbers(vertex['Position [m]']).forEach((part, k) =>
      assert.ok(Math.abs(part - exact[k]) < 1e-6, `${vertex['Position [m]']} is not ${exact}`),
    );
    assert.ok(Number(vertex.Triangles) >= 1 && vertex['Velocity [m/s]'] !== undefined);
    await panel.getByRole('button', { name: 'Edge' }).click();
    const edge = await until(async () => {
      const facts = await readFacts(page).catch(() => ({}));
      return facts.Edge && facts;
    }, 'the edge is not told');
    const ends = edge.Edge.split(',').map((each) => pc2.get(LAST, Number(each))),
      length = Math.hypot(...ends[0].map((part, k) => part - ends[1][k]));
    assert.ok(Math.abs(toNumber(edge['Length [m]']) - length) < 1e-5 && /%$/.test(edge.Strain));
    await panel.getByRole('button', { name: 'Triangle' }).click();
    const triangle = await until(async () => {
      const facts = await readFacts(page).catch(() => ({}));
      return facts['Area [m\u00b2]'] && facts;
    }, 'the triangle is not told');
    assert.ok(/%$/.test(triangle.Warp) && /%$/.test(triangle.Weft) && triangle.Patch !== undefined, JSON.stringify(triangle));
    // A vertex of the sheet that touches the ball has a contact with it.
    await panel.getByLabel('Vertex', { exact: true }).fill('312');
    await panel.getByRole('button', { name: 'Choose' }).click();
    await until(
      async () =>
        /ball/.test(
          await panel
            .locator('.contact')
            .first()
            .innerText()
            .catch(() => ''),
        ),
      'the contact with the ball is not told',
    );
    await page.keyboard.press('Escape');
    await panel.getByText('Click on a surface').waitFor();
    await close(opened);
  },

  async 'watching: a picture, a film, a link'() {
    const opened = await visit(),
      { page, view } = opened;
    await go(opened, 30);
    const take = await openSection(page, 'Take away');
    const [picture] = await Promise.all([page.waitForEvent('download'), take.getByRole('button', { name: 'Picture' }).click()]);
    assert.match(picture.suggestedFilename(), /_30\.png$/);
    const pixels = readPng(fs.readFileSync(await picture.path())),
      box = await page.locator('#view').boundingBox();
    assert.deepEqual([pixels.width, pixels.height], [Math.floor(box.width), Math.floor(box.height)]);
    assert.ok(measure(pixels, isCloth) > 0.03, 'the picture is blank');
    await take.getByLabel('First frame of the film').fill('10');
    await take.getByLabel('Last frame of the film').fill('24');
    await take.getByLabel('Frames a second of the film').fill('15');
    const [film] = await Promise.all([
      page.waitForEvent('download', { timeout: 40000 }),
      take.getByRole('button', { name: 'Make film' }).click(),
    ]);
    assert.match(film.suggestedFilename(), /\.webm$/);
    const bytes = fs.readFileSync(await film.path());
    assert.equal(bytes.readUInt32BE(0), 0x1a45dfa3, 'it is no WebM file');
    const seconds = await measureFilm(page, bytes);
    assert.ok(seconds > 0.6 && seconds < 3, `the film of 15 frames at 15 a second takes ${seconds} s`);
    await go(opened, 33);
    await (await openSection(page, 'Overlays')).getByLabel('Strain along weft').check();
    await view.focus();
    await page.keyboard.press('ArrowRight');
    await page.mouse.click(box.x + box.width / 2, box.y + box.height * 0.45);
    await page.waitForTimeout(600);
    await page.mouse.move(5, 5);
    const here = await settle(page),
      { hash } = new URL(page.url());
    assert.match(hash, /frame=33&camera=.*overlays=weft.*selection=0,/);
    const other = await visit(hash);
    await waitFrame(other.view, 33);
    await until(async () => compare(here, await look(other.page)) < 0.004, 'the link does not lead to the same view');
    await close(other);
    await close(opened);
    await server.stop();
  },
};

// Seconds of a film, by playing it in a page that allows that.
async function measureFilm(page, bytes) {
  const other = await page.context().newPage();
  const seconds = await other.evaluate(async (text) => {
    const video = document.createElement('video');
    video.muted = true;
    video.src = `data:video/webm;base64,${text}`;
    await new Promise((done, fail) => {
      video.onended = done;
      video.onerror = () => fail(new Error('the film does not play'));
      video.play().catch(fail);
    });
    return video.currentTime;
  }, bytes.toString('base64'));
  await other.close();
  return seconds;
}
