// The pictures of the two-minute tour in docs/guide/view.md, with a look that what they are to show is there.
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import { close, open, pictures, root, section, serve, settle, until, waitFrame, work } from './harness.mjs';

const SIZE = { width: 840, height: 540 };
const shoot = (page, name) => page.screenshot({ path: path.join(pictures, `tour_${name}.png`) });

export const checks = {
  async 'tour: a run with overlays, plots and a picked triangle'() {
    const { address, stop } = await serve('watched');
    const opened = await open(address, { viewport: SIZE, fragment: '#frame=27&overlays=contacts,warp' }),
      { page, view } = opened;
    await waitFrame(view, 27);
    await page.getByRole('button', { name: 'Plots' }).click();
    await page.getByRole('combobox', { name: 'Plot' }).selectOption('contacts');
    await until(
      async () => /at step 81: contacts [1-9]/.test(await page.locator('canvas.plot').getAttribute('aria-label')),
      'the plot is empty',
    );
    await page.mouse.move(5, 5);
    await settle(page);
    await shoot(page, 'watch');
    await page.getByRole('button', { name: 'Plots' }).click();
    for (const title of ['Look', 'Overlays']) await section(page, title).locator('summary').click();
    await settle(page);
    const box = await page.locator('#view').boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + box.height * 0.42);
    await until(
      async () =>
        /Warp/.test(await section(page, 'Selection').innerText()) ||
        /Vertex/.test(await section(page, 'Selection').innerText()),
      'nothing is picked',
    );
    await settle(page);
    await page.getByRole('button', { name: 'Triangle' }).click();
    await until(async () => /Area/.test(await section(page, 'Selection').innerText()), 'the triangle is not told');
    await shoot(page, 'pick');
    await close(opened);
    const phone = await open(address, { viewport: { width: 360, height: 640 }, fragment: '#frame=27&overlays=gaps' });
    await waitFrame(phone.view, 27);
    await until(async () => /Gap/.test(await phone.page.locator('.legends').innerText()), 'gaps do not come');
    await settle(phone.page);
    await shoot(phone.page, 'phone');
    await close(phone);
    await stop();
  },

  async 'tour: cloth is pulled, then its text is changed'() {
    fs.copyFileSync(path.join(root, 'scenes/ball.yaml'), path.join(work, 'ball.yaml'));
    const { address, stop } = await serve('ball.yaml'),
      opened = await open(address, { viewport: SIZE }),
      { page } = opened;
    await page.locator('.live-time[data-step]').waitFor();
    await settle(page);
    await page.getByRole('button', { name: 'Grab', exact: true }).click();
    await page.getByLabel('Force [N], as a number').fill('30');
    await page.getByLabel('Force [N], as a number').press('Enter');
    const box = await page.locator('#view').boundingBox(),
      x = box.x + box.width * 0.5,
      y = box.y + box.height * 0.62;
    await page.mouse.move(x, y);
    await page.mouse.down();
    await until(
      async () => (await page.locator('#view[data-held]').count()) > 0,
      `nothing is held: ${await page.locator('#notes').innerText()} ${await page.locator('#status').innerText()}`,
      4000,
    );
    await page.getByRole('button', { name: 'Start' }).evaluate((button) => button.click());
    await page.mouse.move(x + 150, y - 60, { steps: 15 });
    await until(async () => Number(await page.locator('.live-time').getAttribute('data-step')) > 60, 'it does not run');
    await page.locator('button[aria-label=Pause]').evaluate((button) => button.click());
    await settle(page);
    await shoot(page, 'hold');
    await page.mouse.up();
    await page.getByRole('button', { name: 'Edit' }).click();
    await until(
      async () => /title: ball into a sheet/.test(await page.locator('.cm-content').innerText()),
      'the text does not come',
    );
    await page.locator('.cm-line', { hasText: 'preset: cotton' }).click({ position: { x: 40, y: 8 } });
    await page.keyboard.press('End');
    await page.keyboard.press('ArrowLeft');
    for (let k = 0; k < 6; k++) await page.keyboard.press('Backspace');
    await page.keyboard.type('de');
    await page.locator('.cm-tooltip-autocomplete').waitFor();
    await until(
      async () => /problem/.test(await page.locator('.editor-state').innerText()),
      'the unfinished word is no problem',
    );
    assert.match(await page.locator('.cm-tooltip-autocomplete').innerText(), /denim/);
    await settle(page);
    await shoot(page, 'edit');
    await close(opened);
    await stop();
  },
};
