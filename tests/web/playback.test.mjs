// Playback: the end of a motion, loops, speed, and the feet that stand, in a page whose pictures are
// shorter than the frames of the motion.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, shown, until } from './support/browser.mjs';
import { recordDrawing, whenDrawn } from './support/drawing.mjs';
import { storeKnown } from './support/known.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, stream } from './support/stream.mjs';

const kClip = 'databases/known/clips/jump_b';
const kPlace = 'clip/known/jump_b?show=markers,contacts';

async function open(t, place) {
  await storeKnown();
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  // Counts the pictures that the page asks for.
  await page.addInitScript(() => {
    window.pictures = 0;
    const original = window.requestAnimationFrame;
    window.requestAnimationFrame = (call) => {
      ++window.pictures;
      return original.call(window, call);
    };
  });
  await page.goto(`${setup.open}/#/${place}`);
  await shown(page);
  return page;
}

// What the player shows: frame, last frame, text of its button.
const player = (page) =>
  page.evaluate(() => ({
    frame: Number(document.querySelector('.position').textContent.match(/frame (\d+)$/)[1]),
    last: Number(document.querySelector('.player input[type=range]').max),
    button: document.querySelector('.player .play').textContent,
  }));

// Plays the last 10 frames, each for several pictures. Returns the frame where it begins.
async function playLastFrames(page, { loop }) {
  const play = page.locator('.player .play');
  await page.locator('.player').getByLabel('Speed').selectOption('0.25');
  await page.locator('.player').getByLabel('Loop').setChecked(loop);
  await play.press('End');
  for (let i = 0; i < 10; ++i) await play.press(',');
  const { frame, last } = await player(page);
  assert.equal(frame, last - 10);
  await play.press('Enter');
  return frame;
}

async function checkEnd(page) {
  await playLastFrames(page, { loop: false });
  await page.getByRole('button', { name: 'Pause', exact: true }).waitFor();
  await page.getByRole('button', { name: 'Play', exact: true }).waitFor();
  const { frame, last } = await player(page);
  assert.equal(frame, last);
  // Nothing is drawn any more.
  await page.waitForFunction(
    () =>
      new Promise((resolve) => {
        const before = window.pictures;
        setTimeout(() => resolve(window.pictures === before), 300);
      }),
  );
}

async function checkLoop(page) {
  const first = await playLastFrames(page, { loop: true });
  await page.waitForFunction(
    (begin) =>
      Number(document.querySelector('.position').textContent.match(/frame (\d+)$/)[1]) < begin,
    first,
  );
  assert.equal((await player(page)).button, 'Pause');
}

// A place, and what it shows when its motion can play.
const places = [
  ['a clip', kPlace, '.chart canvas'],
  ['a query', 'query/known?clip=jump_b&without=0', '.ribbon rect:visible'],
  ['a plan', 'plan/demo?goal=2,1,0', 'section[aria-label="Planned motions"] tbody tr'],
];
for (const [name, place, content] of places) {
  test(`${name} plays to its end and stops, and begins again with Loop`, async (t) => {
    const page = await open(t, place);
    await page.locator(content).first().waitFor();
    await checkEnd(page);
    await checkLoop(page);
  });
}

test('a selected segment at the end of a clip stops, and begins again with Loop', async (t) => {
  const page = await open(t, kPlace);
  await page.locator('.chart canvas').waitFor();
  await page.locator('.segment-body').first().press('Enter');
  const edge = page.locator('.edge.end');
  await edge.waitFor();
  assert.equal(await edge.getAttribute('aria-valuenow'), await edge.getAttribute('aria-valuemax'));
  await checkEnd(page);
  await checkLoop(page);
});

test('at 0.5 x a motion plays half as fast as at 1 x', async (t) => {
  const page = await open(t, kPlace);
  await page.locator('.chart canvas').waitFor();
  await page.locator('.player').getByLabel('Loop').uncheck();
  // The test moves the clock of the page.
  await page.clock.install();
  await page.clock.pauseAt(Date.now() + 60_000);
  const play = page.locator('.player .play');
  const frames = [];
  for (const speed of ['1', '0.5']) {
    await play.press('Home');
    await page.locator('.player').getByLabel('Speed').selectOption(speed);
    await play.press('Enter');
    await page.clock.runFor(100);
    const { frame: begin, button } = await player(page);
    assert.equal(button, 'Pause');
    await page.clock.runFor(1000);
    frames.push((await player(page)).frame - begin);
    await play.press('Enter');
  }
  // The motion has 60 frames a second, and so have the pictures.
  assert.ok(Math.abs(frames[0] - 60) <= 2, `${frames[0]} frames at 1 x`);
  assert.ok(Math.abs(frames[1] - 30) <= 2, `${frames[1]} frames at 0.5 x`);
});

// Frames of the clip: bits of the feet that stand, and the middle of the markers of each foot.
async function readFeet() {
  const messages = await stream(setup.open, 'ViewService/ReadClipMotion', { name: kClip });
  const { markerNames } = messages[0].figure;
  const contacts = messages.flatMap(({ contacts: bytes }) => [...Buffer.from(bytes, 'base64')]);
  const positions = messages.flatMap(({ markerPositions }) => floatsOf(markerPositions));
  const feet = ['L', 'R'].map((side) =>
    markerNames.flatMap((name, i) =>
      name.startsWith(side) && /ankle|heel|toe|foot|ball/i.test(name) ? [i] : [],
    ),
  );
  assert.ok(feet.every((markers) => markers.length > 0));
  const middleOf = (frame, foot) =>
    [0, 1].map((axis) => {
      const values = feet[foot].map((i) => positions[3 * (frame * markerNames.length + i) + axis]);
      return values.reduce((sum, value) => sum + value, 0) / values.length;
    });
  return { contacts, middleOf };
}

// Discs below the feet: [x, y] of the left and the right one; null: none.
async function checkDiscs(page, frame, { contacts, middleOf }) {
  const expected = [0, 1].map((foot) =>
    (contacts[frame] & (1 << foot)) === 0 ? null : middleOf(frame, foot),
  );
  await whenDrawn(page, '.scene canvas', (drawn) => {
    // Two instances without a marker at this place: all markers are higher than the discs.
    const discs = drawn.filter(({ instances, matrices }) => {
      const heights = [14, 30].map((i) => matrices[i]);
      return instances === 2 && heights.every((z) => z === 0 || Math.abs(z - 0.004) < 1e-6);
    });
    assert.equal(discs.length, 1, 'draw calls of discs');
    const { matrices } = discs[0];
    const places = [0, 16].map((at) =>
      matrices[at] === 0 ? null : [matrices[at + 12], matrices[at + 13]],
    );
    for (const foot of [0, 1]) {
      const [at, right] = [places[foot], expected[foot]];
      const away = at && right ? Math.hypot(at[0] - right[0], at[1] - right[1]) : at === right;
      assert.ok(away === true || away < 1e-4, `foot ${foot} of frame ${frame}: ${at}, ${right}`);
    }
  });
}

test('contacts are those of the server, on the floor and in the timeline', async (t) => {
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await storeKnown();
  const feet = await readFeet();
  const { contacts } = feet;
  assert.ok(new Set(contacts).size > 1, 'feet that stand and feet that do not');
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/${kPlace}`);
  await page.locator('.contacts canvas').waitFor();
  // A frame of each combination of feet, and the frames at which it changes.
  const changes = contacts.flatMap((byte, frame) => (byte !== contacts[frame - 1] ? [frame] : []));
  for (const frame of new Set(
    changes.slice(0, 6).flatMap((each) => [Math.max(0, each - 1), each]),
  )) {
    await page.getByLabel('Frame', { exact: true }).fill(String(frame));
    await checkDiscs(page, frame, feet);
  }
  // Stripes over time: left above, right below.
  const stripes = () =>
    page.locator('.contacts canvas').evaluate((canvas, count) => {
      const { width, height } = canvas;
      // A copy: the browser warns if a canvas is read several times.
      const copy = new OffscreenCanvas(width, height).getContext('2d', {
        willReadFrequently: true,
      });
      copy.drawImage(canvas, 0, 0);
      const { data } = copy.getImageData(0, 0, width, height);
      return Array.from({ length: count }, (_, frame) => {
        const x = Math.floor(((frame + 0.5) * width) / count);
        const isDrawn = (part) => data[4 * (Math.floor(part * height) * width + x) + 3] > 0;
        return (isDrawn(0.2) ? 1 : 0) + (isDrawn(0.7) ? 2 : 0);
      });
    }, contacts.length);
  await until(async () => assert.deepEqual(await stripes(), contacts), 60);
});
