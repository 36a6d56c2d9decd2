// The player of a clip: positions, segments, speed of drawing, memory.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown } from './support/browser.mjs';
import { project } from './support/projection.mjs';
import { setup } from './support/setup.mjs';
import { markersAt } from './support/stream.mjs';

const clip = 'databases/demo/clips/01_01';

async function openClip(t, query, options) {
  const page = await newPage(t, options);
  await page.goto(`${setup.open}/#/clip/demo/01_01?${query}`);
  await shown(page);
  await page.locator('.segment').first().waitFor();
  await page.locator('.chart canvas').waitFor();
  return page;
}

test('the rendered points are the positions of the server', async (t) => {
  const frame = 60;
  const markers = await markersAt(setup.open, clip, frame);
  const [, x, y] = markers.find(([name]) => name === 'Pelvis');
  const eye = [x + 2.5, y - 2.5, 1.75].map((value) => Number(value.toFixed(2)));
  const target = [x, y, 1].map((value) => Number(value.toFixed(2)));
  const camera = [...eye, ...target].join(',');
  const page = await openClip(t, `t=1.0001&show=markers&camera=${camera}`);
  const box = await page.locator('.scene canvas').boundingBox();
  let same = 0;
  for (const [name, ...point] of markers) {
    const [left, top] = project(point, eye, target, box.width, box.height);
    await page.mouse.move(box.x + left, box.y + top);
    const shownText = await page.locator('.scene .overlay').textContent();
    const [, ...numbers] = shownText.match(/x (\S+) {2}y (\S+) {2}z (\S+) m/) ?? [];
    if (!shownText.startsWith(`${name} `)) continue;
    numbers.forEach((text, axis) => assert.ok(Math.abs(Number(text) - point[axis]) < 6e-4, shownText));
    ++same;
  }
  // Some markers are in front of others.
  assert.ok(same >= 0.8 * markers.length, `${same} of ${markers.length}`);
});

test('segments are created, moved by keys, and deleted', async (t) => {
  const page = await openClip(t, '');
  await page.fill('.segment-form input >> nth=0', 'hands');
  await page.fill('.segment-form input >> nth=1', 'wave');
  await page.getByRole('button', { name: 'Add segment from here' }).click();
  const segment = page.locator('.segment-body', { hasText: 'wave' });
  await segment.waitFor();
  const before = await segment.getAttribute('aria-label');
  await page.locator('.edge.end').focus();
  await page.keyboard.press('ArrowLeft');
  await page.waitForFunction(
    (text) => ![...document.querySelectorAll('.segment-body')].some((node) => node.getAttribute('aria-label') === text),
    before,
  );
  await checkAccessibility(page);
  await page.getByRole('button', { name: 'Delete' }).click();
  await segment.waitFor({ state: 'detached' });
});

test('speed and loop are in the address', async (t) => {
  const page = await openClip(t, 'speed=0.3');
  const speed = page.locator('.player').getByLabel('Speed');
  assert.equal(await speed.inputValue(), '1'); // 0.3 is not offered
  await speed.selectOption('0.25');
  await page.getByLabel('Loop').uncheck();
  await page.waitForURL(/speed=0\.25.*loop=0/);
  await page.reload();
  assert.equal(await speed.inputValue(), '0.25');
  assert.equal(await page.getByLabel('Loop').isChecked(), false);
});

test('the keyboard plays and steps, and the recorded skeleton can be alone', async (t) => {
  const page = await openClip(t, 't=1');
  const position = page.locator('.position');
  await position.getByText('frame 60').waitFor();
  await page.keyboard.press('.');
  await position.getByText('frame 61').waitFor();
  await page.keyboard.press(',');
  await page.keyboard.press(',');
  await position.getByText('frame 59').waitFor();
  await page.waitForURL(/t=0\.98/);
  await page.keyboard.press('Space');
  await page.getByRole('button', { name: 'Pause' }).waitFor();
  await page.keyboard.press('Space');
  await page.keyboard.press('Home');
  await position.getByText('frame 0').waitFor();
  await page.getByLabel('Recorded skeleton').check();
  await page.getByLabel('Markers').uncheck();
  await page.waitForURL(/show=joints/);
  const box = await page.locator('.scene canvas').boundingBox();
  const names = new Set();
  for (let y = 0.2; y < 0.8; y += 0.04) {
    await page.mouse.move(box.x + box.width / 2, box.y + y * box.height);
    const text = await page.locator('.scene .overlay').textContent();
    if (text) names.add(text.split('  ')[0]);
  }
  // Names of the file, not of the marker set.
  const joints = await page.locator('option[value^="joint:"]').evaluateAll((options) =>
    options.map((option) => option.value.slice('joint:'.length)),
  );
  assert.ok(names.size > 0);
  for (const name of names) assert.ok(joints.includes(name), name);
});

test('without WebGL the player, segments and curves work', async (t) => {
  const page = await newPage(t);
  await disableWebGL(page);
  await page.goto(`${setup.open}/#/clip/demo/01_01`);
  await page.locator('.chart canvas').waitFor();
  await page.getByRole('button', { name: 'Play' }).click();
  await page.waitForFunction(() => /frame [1-9]/.test(document.querySelector('.position').textContent));
});
