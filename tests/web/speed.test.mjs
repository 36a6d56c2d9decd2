// Speed of the page, with the bars that the project requires: first view, a long clip that plays, and
// a map of 100,000 nodes. Prints a line `BAR ...` for each.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { checkBar } from './support/bars.mjs';
import { newPage, shown } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { largeMap } from './support/large_map.mjs';
import { markPictures, percentile, workOfPictures } from './support/main_thread.mjs';
import { call, motiondb } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const screen = { viewport: { width: 800, height: 600 }, deviceScaleFactor: 1 };
const kFirstViews = 5;

test('the first view appears', async (t) => {
  const page = await newPage(t, screen);
  const row = page.locator('main tbody tr').first();
  const times = [];
  for (let i = 0; i <= kFirstViews; ++i) {
    await page.goto('about:blank');
    const began = performance.now();
    await page.goto(`${setup.open}/`);
    await row.waitFor();
    times.push(performance.now() - began);
  }
  // The first one fills the caches of server and browser.
  t.diagnostic(`first views after ${times.map((time) => time.toFixed(0)).join(', ')} ms`);
  checkBar(t, 'first view on loopback, median', percentile(times.slice(1), 0.5), 'ms', {
    most: 1000,
  });
});

// A file of 20,000 frames at 120 Hz: a recorded motion forwards and backwards.
async function storeLongClip() {
  const motion = await readBvh('01_01');
  const { rows } = motion;
  const turn = 2 * (rows.length - 1);
  const frames = Array.from({ length: 20_000 }, (_, i) => {
    const at = i % turn;
    return rows[at < rows.length ? at : turn - at];
  });
  const file = join(setup.folder, 'long.bvh');
  await writeFile(file, bvhOf(motion, frames));
  await motiondb('create', 'long');
  await motiondb('ingest', 'long', file, '--label', 'jump');
}

test('a clip of 10,000 frames plays smoothly', async (t) => {
  await storeLongClip();
  const { body } = await call(setup.open, 'ClipService/GetClip', {
    name: 'databases/long/clips/long',
  });
  assert.ok(Math.abs(body.clip.frameCount - 10_000) < 10, `${body.clip.frameCount} frames`);
  const page = await newPage(t, screen);
  await markPictures(page);
  await page.goto(`${setup.open}/#/clip/long/long?statistics=1`);
  await page.locator('.chart canvas').waitFor();
  await page.getByRole('button', { name: 'Play' }).click();
  await page.waitForTimeout(1500);
  const statistics = () =>
    page.evaluate(() => ({ ...document.querySelector('.statistics').dataset }));
  const before = Number((await statistics()).pictures);
  // The trace costs time itself, so these figures are of another interval.
  await page.waitForTimeout(4000);
  const { p95, calls, rate, pictures } = await statistics();
  const work = await workOfPictures(page, async () => {
    await page.waitForTimeout(2000);
    await page.getByRole('button', { name: 'Pause' }).click();
  });
  t.diagnostic(
    `${Number(pictures) - before} pictures in 4 s; trace of ${work.length} pictures: main thread ` +
      `${percentile(work, 0.5).toFixed(2)} ms (median) of processor time`,
  );
  const bars = [
    ['main thread, all work of a picture, 95 %', percentile(work, 0.95), 'ms', { most: 6 }],
    ['main thread, motion and drawing of a picture, 95 %', Number(p95), 'ms', { most: 6 }],
    ['pictures', Number(rate), 'Hz', { least: 20 }],
  ];
  checkBar(t, 'draw calls of a picture', Number(calls), 'calls', { most: 100 }, false);
  assert.ok(Number(calls) > 0);
  for (const bar of bars) checkBar(t, ...bar);
});

test('a map of 100,000 nodes is interactive', async (t) => {
  // The server has no such node, so the mean pose of the one under the pointer is an error.
  const page = await newPage(t, { ...screen, expected: [/GetNodePoses/] });
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
  t.diagnostic(`map after ${loaded.toFixed(0)} ms`);
  const box = await canvas.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.locator('.node-panel', { hasText: /Node \d+ of layer/ }).waitFor();
  const clicks = await page.evaluate(async () => {
    const target = document.querySelector('.map canvas');
    const box = target.getBoundingClientRect();
    const picture = () => new Promise((resolve) => requestAnimationFrame(resolve));
    const places = new Set();
    const start = performance.now();
    for (let step = 0; step < 20; ++step) {
      const clientX = box.left + box.width / 2 + 5 * step;
      const at = { clientX, clientY: box.top + box.height / 2, bubbles: true };
      target.dispatchEvent(new MouseEvent('click', at));
      await picture();
      places.add(document.querySelector('.node-panel .hint').textContent);
    }
    return { milliseconds: (performance.now() - start) / 20, chosen: places.size };
  });
  assert.ok(clicks.chosen > 5, `${clicks.chosen} nodes chosen`);
  checkBar(t, 'map of 100,000 nodes, a step of the camera', milliseconds, 'ms', { most: 200 });
  checkBar(t, 'map of 100,000 nodes, a click on a node', clicks.milliseconds, 'ms', { most: 200 });
});
