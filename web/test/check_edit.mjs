// Editing a scene beside its picture.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { close, open, serve, until, work } from './harness.mjs';
import { LIVE } from './make_data.mjs';

let server;
const file = path.join(work, 'edited.yaml');
const visit = async () => {
  fs.writeFileSync(file, LIVE);
  if (server) await server.stop();
  server = await serve('edited.yaml');
  const opened = await open(server.address),
    { page } = opened;
  await page.getByRole('button', { name: 'Edit' }).click();
  const editor = page.locator('.cm-content');
  await until(async () => (await read(page)).includes('title: a curtain'), 'the text of the scene does not come');
  return { ...opened, editor, state: page.locator('.editor-state') };
};
// The whole text, also of lines that are not drawn.
const read = (page) =>
  page.locator('.editor-host').evaluate((host) => {
    const lines = host.shadowRoot.querySelectorAll('.cm-line');
    return [...lines].map((line) => line.textContent).join('\n');
  });
const goTo = async (page, editor, line) => {
  await editor.click();
  await page.keyboard.press('Control+Home');
  for (let k = 1; k < line; k++) await page.keyboard.press('ArrowDown');
  await page.keyboard.press('End');
};
const lineOf = (words) => LIVE.split('\n').findIndex((line) => line.includes(words)) + 1;

export const checks = {
  async 'editing: the text, its problems at their place, a save that loads it anew'() {
    const opened = await visit(),
      { page, editor, state } = opened;
    assert.equal((await read(page)).trim(), LIVE.trim());
    await goTo(page, editor, lineOf('preset: cotton'));
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.type('x');
    await until(
      async () => new RegExp(`1 problem: line ${lineOf('preset')}, column \\d+: .*cottonx`).test(await state.innerText()),
      'the problem is not told at its place',
    );
    await page.locator('.cm-lintRange-error').first().waitFor();
    await page.locator('.cm-lint-marker-error').first().waitFor();
    assert.ok(!(await page.locator('.cm-lintRange-error').first().innerText()).includes('mesh'));
    await page.getByRole('button', { name: 'Save', exact: true }).click();
    await until(async () => /problem/.test(await state.innerText()), 'a save with problems is not refused');
    assert.equal(fs.readFileSync(file, 'utf8'), LIVE, 'a scene with problems was written');
    await page.getByRole('button', { name: 'Problems' }).click();
    await page.locator('.cm-panel-lint', { hasText: 'cottonx' }).waitFor();
    await editor.click();
    await goTo(page, editor, lineOf('preset: cotton'));
    await page.keyboard.press('ArrowLeft');
    await page.keyboard.press('Backspace');
    await until(async () => /no problems/.test(await state.innerText()), 'the problem stays');
    await goTo(page, editor, lineOf('resolution: [17, 17]'));
    for (let k = 0; k < 4; k++) await page.keyboard.press('Backspace');
    await page.keyboard.type('9]}');
    await until(async () => /no problems/.test(await state.innerText()), 'a good text has problems');
    await page.keyboard.press('Control+s');
    await until(async () => /saved and loaded/.test(await state.innerText()), 'it is not saved');
    assert.match(fs.readFileSync(file, 'utf8'), /resolution: \[17, 9\]/);
    await until(
      async () => /curtain \(cloth, 256 triangles\)/.test(await opened.view.getAttribute('aria-label')),
      'the picture is still that of the old scene',
    );
    await page.getByRole('button', { name: 'Start' }).click();
    await until(
      async () => Number(await page.locator('.live-time').getAttribute('data-step')) > 5,
      'the new scene does not run',
    );
    await close(opened);
  },

  async 'editing: completion knows the keys and their words'() {
    const opened = await visit(),
      { page, editor } = opened;
    // An offer takes keys only when it has been there for a moment.
    const offers = async (words) => {
      await until(
        async () =>
          (
            await page
              .locator('.cm-tooltip-autocomplete')
              .innerText()
              .catch(() => '')
          ).includes(words),
        `${words} is not offered`,
      );
      await page.waitForTimeout(200);
    };
    await goTo(page, editor, lineOf('preset: cotton'));
    await page.keyboard.press('Enter');
    await page.keyboard.type('    fri');
    await offers('friction');
    await page.keyboard.press('Escape');
    await page.keyboard.press('Home');
    await page.keyboard.press('Shift+End');
    await page.keyboard.press('Backspace');
    await page.keyboard.press('Backspace');
    await goTo(page, editor, lineOf('preset: cotton'));
    await page.keyboard.press('ArrowLeft');
    for (let k = 0; k < 6; k++) await page.keyboard.press('Backspace');
    await page.keyboard.type('de');
    await offers('denim');
    await page.keyboard.press('Enter');
    await until(async () => (await read(page)).includes('{preset: denim}'), 'what was chosen is not put in');
    await page.keyboard.press('Control+Home');
    await page.keyboard.type('win');
    await offers('wind');
    await page.keyboard.press('Enter');
    assert.match(await read(page), /^wind: /);
    await close(opened);
  },

  async 'editing: an example to begin from, by keys alone, and out again by Escape and Tab'() {
    const opened = await visit(),
      { page, state } = opened;
    await page.getByLabel('Begin from').selectOption({ label: 'net' });
    await until(
      async () => (await read(page)).includes('title:') && !(await read(page)).includes('a curtain'),
      'the example does not come',
    );
    await until(async () => /not saved/.test(await state.innerText()), 'nothing says that it is not saved');
    assert.equal(fs.readFileSync(file, 'utf8'), LIVE, 'the example was written without being saved');
    await page.locator('.cm-content').focus();
    await page.keyboard.press('Escape');
    await page.keyboard.press('Tab');
    assert.ok(await page.evaluate(() => !document.activeElement?.classList.contains('editor-host')), 'Tab stays in the editor');
    await close(opened);
  },

  async 'editing: a scene with errors opens with them'() {
    fs.writeFileSync(path.join(work, 'broken.yaml'), LIVE.replace('preset: cotton', 'preset: coton'));
    const broken = await serve('broken.yaml'),
      opened = await open(broken.address),
      { page } = opened;
    await until(
      async () =>
        /line \d+, column \d+: .*coton/.test(
          await page
            .locator('.editor-state')
            .innerText()
            .catch(() => ''),
        ),
      'the problem is not shown',
    );
    await close(opened);
    await broken.stop();
    await server.stop();
  },
};
