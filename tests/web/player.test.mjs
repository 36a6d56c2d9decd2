// Trails and the camera that follows, in the player of a clip: against the positions of the server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, shown } from './support/browser.mjs';
import { distance, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { setup } from './support/setup.mjs';
import { motionOf } from './support/stream.mjs';

const clip = 'databases/demo/clips/01_01';
const canvas = '.scene canvas';
const kTrailFrames = 60; // 1 s

async function openClip(t, query) {
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/clip/demo/01_01?${query}`);
  await shown(page);
  await page.locator('.chart canvas').waitFor();
  return page;
}

// Steps of the path of a marker in the second before a frame, each as the positions of both ends.
function pathOf({ names, frames }, marker, frame) {
  const at = (index) =>
    frames[index].slice(3 * names.indexOf(marker), 3 * names.indexOf(marker) + 3);
  return Array.from({ length: kTrailFrames }, (_, step) => [
    ...at(frame - step - 1),
    ...at(frame - step),
  ]);
}

// The trails in a picture. The lines of the floor are at height 0.
const trailsIn = (drawn) =>
  drawn.filter(
    ({ kind, positions }) =>
      kind === 'lines' && positions.some((value, i) => i % 3 === 2 && value !== 0),
  );

test('a trail is the path of its marker in the last second', async (t) => {
  const motion = await motionOf(setup.open, clip, { frameCount: 62 });
  const page = await openClip(t, 't=1&show=markers,trails');
  const check = (markers, frame) =>
    whenDrawn(page, canvas, (drawn) => {
      const trails = trailsIn(drawn);
      assert.equal(trails.length, 1, 'draw calls of trails');
      const paths = markers.flatMap((marker) => pathOf(motion, marker, frame).flat());
      assert.ok(
        distance(trails[0].positions, paths) < 1e-5,
        `trails of ${markers} at frame ${frame}`,
      );
    });
  const ends = motion.names.filter((name) => /hand|wrist|toe|ankle/i.test(name));
  assert.ok(ends.length >= 4, ends.join());
  await check(ends, 60);
  // Another point while the motion stands still.
  await page.getByLabel('Point').selectOption('LHeel');
  await check(['LHeel'], 60);
  await page.locator(canvas).focus();
  await page.keyboard.press('.');
  await check(['LHeel'], 61);
  await page.getByLabel('Trails').uncheck();
  await whenDrawn(page, canvas, (drawn) => assert.equal(trailsIn(drawn).length, 0));
});

test('the camera follows the figure only if that is chosen', async (t) => {
  const motion = await motionOf(setup.open, clip);
  const centreOf = (frame) =>
    [0, 1].map((axis) => {
      const values = frame.filter((_, i) => i % 3 === axis);
      return values.reduce((sum, value) => sum + value, 0) / values.length;
    });
  const last = centreOf(motion.frames.at(-1));
  const eye = [3, -4, 2];
  const target = [0.5, 0.25, 1];
  // A key that turns the camera puts its place in the address.
  const cameraOf = async (page) => {
    const textOf = (address) => decodeURIComponent(address).match(/camera=([-\d.,]+)/)[1];
    const before = textOf(page.url());
    await page.locator(canvas).press('ArrowLeft');
    await page.waitForURL((url) => textOf(url.href) !== before);
    const values = textOf(page.url()).split(',').map(Number);
    return { eye: values.slice(0, 3), target: values.slice(3) };
  };
  const length = ({ eye: from, target: to }) =>
    Math.hypot(...from.map((value, i) => value - to[i]));
  const page = await openClip(t, `show=markers&camera=${[...eye, ...target].join(',')}`);
  const checkCamera = async (expected, what) => {
    const camera = await cameraOf(page);
    assert.ok(distance(camera.target, expected) < 0.011, `${what}: ${camera.target}, ${expected}`);
    assert.ok(
      Math.abs(length(camera) - length({ eye, target })) < 0.03,
      `${what}: ${length(camera)} m`,
    );
  };
  const follow = page.getByLabel('Follow camera');
  await page.keyboard.press('End');
  await page.locator('.position', { hasText: `frame ${motion.frames.length - 1}` }).waitFor();
  await checkCamera(target, 'stands still');
  await follow.check();
  await checkCamera([...last, target[2]], 'follows at once');
  await page.keyboard.press('Home');
  await page.locator('.position', { hasText: 'frame 0' }).waitFor();
  const first = centreOf(motion.frames[0]);
  await checkCamera([...first, target[2]], 'follows to the first frame');
  await follow.uncheck();
  await page.keyboard.press('End');
  await page.locator('.position', { hasText: `frame ${motion.frames.length - 1}` }).waitFor();
  await checkCamera([...first, target[2]], 'stays');
  assert.ok(
    distance(last, first) > 0.5 && distance(last, target.slice(0, 2)) > 0.5,
    'the figure moves',
  );
});

test('a picture of all parts has at most 100 draw calls', async (t) => {
  const page = await openClip(t, 't=1&show=markers,joints,contacts,trails');
  await whenDrawn(page, canvas, (drawn) => {
    assert.ok(drawn.length >= 7 && drawn.length <= 100, `${drawn.length} draw calls`);
  });
});
