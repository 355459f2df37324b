// How many frames a second come and are drawn, of 20,000 and of 200,000 triangles that all move in a live scene. Where Chromium draws
// by software, the simulation, the drawing and the browser share the processor; with the surfaces hidden nothing is drawn.
import assert from 'node:assert/strict';
import { close, open, section, serve, until } from './harness.mjs';

const SECONDS = 4;

async function measure(page) {
  const corner = page.getByTestId('counts');
  let drawn = 0,
    received = 0;
  await page.waitForTimeout(1200);
  for (let k = 0; k < SECONDS; k++) {
    await page.waitForTimeout(1000);
    const counts = await corner.evaluate(({ dataset }) => ({
      drawn: Number(dataset.drawn),
      received: Number(dataset.received),
    }));
    drawn += counts.drawn / SECONDS;
    received += counts.received / SECONDS;
  }
  return { drawn, received };
}

async function tell(name, triangles) {
  const { address, stop } = await serve(`${name}.yaml`),
    opened = await open(address),
    { page, view } = opened;
  await page.locator('.live-time[data-step]').waitFor();
  await page.getByLabel('Speed of the simulation').selectOption('0');
  await view.focus();
  await page.keyboard.press('c');
  await page.keyboard.press('Space');
  await until(async () => Number(await page.locator('.live-time').getAttribute('data-step')) > 3, 'it does not run', 60000);
  const shown = await measure(page),
    how = /software/.test(await page.getByTestId('counts').innerText()) ? 'by software' : 'by a graphics card';
  await section(page, 'Objects').locator('summary').click();
  for (const box of await section(page, 'Objects').getByRole('checkbox').all()) await box.uncheck();
  const hidden = await measure(page),
    steps = /([\d.]+) steps a second/.exec(await page.locator('.live-time').innerText())?.[1];
  console.log(
    `   ${triangles} triangles: ${shown.received.toFixed(1)} received and ${shown.drawn.toFixed(1)} drawn a second ${how}; ` +
      `${hidden.received.toFixed(1)} received with the surfaces hidden; ${steps} steps a second of the simulation`,
  );
  await close(opened);
  await stop();
  return { shown, hidden };
}

export const checks = {
  async 'rates: 20,000 triangles'() {
    const { shown, hidden } = await tell('large20', 20000);
    assert.ok(shown.drawn > 0.5 && hidden.received > 5);
  },

  async 'rates: 200,000 triangles'() {
    const { shown, hidden } = await tell('large200', 200000);
    assert.ok(shown.drawn > 0.2 && hidden.received > 1);
  },
};
