// Speed of the pictures: a long clip that plays, and a map of 100,000 nodes.
import assert from 'node:assert/strict';
import { readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { newPage, shown } from './support/browser.mjs';
import { isBusy } from './support/busy.mjs';
import { motiondb } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { largeMap } from './support/large_map.mjs';

const viewport = { width: 800, height: 600 };

// A file of 20,000 frames at 120 Hz: a recorded motion forwards and backwards.
async function storeLongClip() {
  const lines = (await readFile(`${setup.models}/01_01.bvh`)).toString().split('\n');
  const begin = lines.findIndex((line) => line.startsWith('Frames:'));
  const rows = lines.slice(begin + 2).filter((line) => line.trim() !== '');
  const turn = 2 * (rows.length - 1);
  const frames = Array.from({ length: 20_000 }, (_, i) => {
    const at = i % turn;
    return rows[at < rows.length ? at : turn - at];
  });
  const head = [...lines.slice(0, begin), `Frames: ${frames.length}`, lines[begin + 1]];
  const file = join(setup.folder, 'long.bvh');
  await writeFile(file, [...head, ...frames, ''].join('\n'));
  await motiondb('create', 'long');
  await motiondb('ingest', 'long', file, '--label', 'jump');
}

test('a clip of 10,000 frames plays smoothly', async (t) => {
  await storeLongClip();
  const page = await newPage(t, { viewport });
  await page.goto(`${setup.open}/#/clip/long/long?statistics=1`);
  await page.locator('.chart canvas').waitFor();
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  const scriptSeconds = async () => {
    const { metrics } = await session.send('Performance.getMetrics');
    return metrics.find(({ name }) => name === 'ScriptDuration').value;
  };
  await page.getByRole('button', { name: 'Play' }).click();
  await page.waitForTimeout(1500);
  const pictures = () =>
    page.evaluate(() => Number(document.querySelector('.statistics').dataset.pictures));
  const [scriptBefore, before] = [await scriptSeconds(), await pictures()];
  await page.waitForTimeout(4000);
  const [scriptAfter, after] = [await scriptSeconds(), await pictures()];
  const { p95, calls, rate } = await page.evaluate(() => ({
    ...document.querySelector('.statistics').dataset,
  }));
  const mean = (1000 * (scriptAfter - scriptBefore)) / Math.max(1, after - before);
  t.diagnostic(
    `${after - before} pictures: script ${mean.toFixed(2)} ms a picture, work of a picture ` +
      `${p95} ms (95 %), ${calls} draw calls, ${rate} Hz${isBusy() ? ', busy machine' : ''}`,
  );
  assert.ok(Number(calls) <= 100 && Number(calls) > 0);
  assert.ok(mean <= 6);
  if (isBusy()) return;
  assert.ok(Number(p95) <= 6);
  assert.ok(Number(rate) >= 20);
});

test('a map of 100,000 nodes is interactive', async (t) => {
  // The server has no such node, so the mean pose of the one under the pointer is an error.
  const page = await newPage(t, { viewport, expected: [/GetNodePoses/] });
  const body = largeMap(100_000);
  await page.route('**/motiondb.v1.ViewService/ReadStateMap', (route) =>
    route.fulfill({ status: 200, contentType: 'application/connect+proto', body }),
  );
  const began = performance.now();
  await page.goto(`${setup.open}/#/database/demo?layer=4`);
  await shown(page);
  await page.locator('.map-controls output', { hasText: 'Layer' }).waitFor();
  const loaded = performance.now() - began;
  const canvas = page.locator('.map canvas');
  await canvas.focus();
  const milliseconds = await page.evaluate(async () => {
    const target = document.querySelector('.map canvas');
    const picture = () => new Promise((resolve) => requestAnimationFrame(resolve));
    await picture();
    const start = performance.now();
    for (let step = 0; step < 30; ++step) {
      target.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowLeft', bubbles: true }));
      await picture();
    }
    return (performance.now() - start) / 30;
  });
  t.diagnostic(
    `map after ${loaded.toFixed(0)} ms, ${milliseconds.toFixed(0)} ms a step of the camera` +
      (isBusy() ? ', busy machine' : ''),
  );
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.locator('.node-panel', { hasText: /Node \d+ of layer/ }).waitFor();
  if (!isBusy()) assert.ok(milliseconds < 200);
});
