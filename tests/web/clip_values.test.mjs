// The view of a clip with the numbers of the server: both stages, curves, and segments that the
// pointer moves, with the update of the model that follows.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage } from './support/browser.mjs';
import { checkLines, recordCharts } from './support/charts.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { storeKnown } from './support/known.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, motionOf, stream } from './support/stream.mjs';

const kClip = 'databases/known/clips/jump_b';
const kRate = 60; // Hz, of both clips

// Fails if the n-th stage does not show a frame.
async function checkStage(page, n, { frames }, frame) {
  await whenDrawn(page, `.motion-pane:nth-child(${n}) canvas`, (drawn) => {
    const nearest = Math.min(
      ...drawn.map((each) => distance(placesOfInstances(each), frames[frame])),
    );
    assert.ok(nearest < 1e-4, `frame ${frame} on stage ${n}: ${nearest} m away`);
  });
}

async function checkStages(page, first, second) {
  await checkStage(page, 1, first, 30);
  await checkStage(page, 2, second, 45);
  await page.keyboard.press('.');
  await checkStage(page, 1, first, 31);
  await checkStage(page, 2, second, 46);
  const offset = page.getByLabel('Offset, s');
  await offset.fill('-0.25');
  await offset.press('Enter');
  await checkStage(page, 2, second, 16);
  await checkStage(page, 1, first, 31);
  // Before its start the second clip shows its first frame.
  await offset.fill('-1');
  await offset.press('Enter');
  await checkStage(page, 2, second, 0);
  await page.getByRole('button', { name: 'Align' }).press('Enter');
  await page.waitForURL((url) => /offset=-?\d/.test(url) && !/offset=-1(&|$)/.test(url));
  const found = Number(await offset.inputValue());
  const frame = Math.max(0, Math.floor((31 / kRate + found) * kRate + 1e-6));
  await checkStage(page, 2, second, Math.min(frame, second.frames.length - 1));
}

// Points [time, value] of the values of frames.
const overTime = (values) => values.map((value, frame) => [frame / kRate, value]);

async function checkCurves(page, { frames, names }) {
  const canvas = page.locator('.chart canvas');
  const [point, kind] = await page.getByRole('region', { name: 'Curves' }).locator('select').all();
  await canvas.waitFor();
  const at = 3 * names.indexOf('LHand');
  const hand = frames.map((frame) => frame.slice(at, at + 3));
  const axes = [0, 1, 2].map((axis) => overTime(hand.map((place) => place[axis])));
  assert.equal(new Set(await checkLines(canvas, axes, 'position')).size, 3);
  const shownFrame = async () =>
    Number((await page.locator('.position').textContent()).match(/frame (\d+)$/)[1]);
  const values = page.locator('.curve-values');
  const moment = await shownFrame();
  const [x, y, z] = hand[moment].map((value) => value.toFixed(3));
  assert.equal(await values.textContent(), `x ${x}, y ${y}, z ${z} m`);
  await kind.selectOption('speed');
  const speeds = hand.map((_, frame) => {
    const [low, high] = [Math.max(0, frame - 1), Math.min(hand.length - 1, frame + 1)];
    const step = hand[high].map((value, axis) => value - hand[low][axis]);
    return (Math.hypot(...step) * kRate) / (high - low);
  });
  await checkLines(canvas, [overTime(speeds)], 'speed');
  assert.equal(await values.textContent(), `speed ${speeds[moment].toFixed(3)} m/s`);
  const [block] = await stream(setup.open, 'ViewService/ReadClipMotion', {
    name: kClip,
    joints: true,
  });
  const { jointNames } = block.figure;
  const joints = floatsOf(block.jointPositions);
  await kind.selectOption('height');
  await point.selectOption('joint:LeftHand');
  const joint = jointNames.indexOf('LeftHand');
  const heights = frames.map((_, frame) => joints[3 * (frame * jointNames.length + joint) + 2]);
  await checkLines(canvas, [overTime(heights)], 'height of a joint');
  // A click goes to the moment.
  await canvas.evaluate((node) => node.scrollIntoView());
  const box = await page.locator('.chart .u-over').boundingBox();
  const click = async (part) => {
    await page.mouse.click(box.x + part * box.width, box.y + box.height / 2);
    return shownFrame();
  };
  const checkFrame = (frame, part) =>
    assert.ok(Math.abs(frame - part * frames.length) <= 2, `frame ${frame}`);
  checkFrame(await click(0.5), 0.5);
  // Keys zoom about this moment.
  await page.locator('.chart').focus();
  await page.keyboard.press('+');
  checkFrame(await click(0.1), 0.5 - 0.4 / 1.5);
  await page.keyboard.press('0');
  checkFrame(await click(0.1), 0.1);
}

async function storedSegments() {
  const { body } = await call(setup.open, 'SegmentService/ListSegments', { parent: kClip });
  return body.segments.map(({ label, startSeconds: start = 0, endSeconds: end }) => ({
    label,
    start,
    end,
  }));
}

// Records what the progress of the operation shows.
const recordProgress = (page) =>
  page.evaluate(() => {
    const node = document.querySelector('.operation');
    window.progress = [];
    const record = () => {
      const bar = node.querySelector('progress');
      const { textContent: text } = node.querySelector('[role=status]');
      window.progress.push({ text, value: bar.value, hidden: bar.hidden });
    };
    new MutationObserver(record).observe(node, {
      childList: true,
      subtree: true,
      attributes: true,
    });
  });

// The model is updated: the progress rises until the server has done it.
async function checkProgress(page) {
  await page.locator('.operation', { hasText: 'Model is up to date.' }).waitFor();
  const shown = await page.evaluate(() => window.progress.splice(0));
  const running = shown.filter(({ text }) => text.startsWith('Model: '));
  assert.ok(running.length > 0, JSON.stringify(shown));
  for (const [i, { text, value }] of running.entries()) {
    assert.match(text, new RegExp(`^Model: .*, ${Math.round(100 * value)} %$`));
    assert.ok(value >= (running[i - 1]?.value ?? 0), 'progress does not fall');
  }
  assert.equal(shown.at(-1).hidden, true);
  const { body } = await call(setup.open, 'OperationService/ListOperations', {
    parent: 'databases/known',
    pageSize: 1,
  });
  assert.equal(body.operations[0].state, 'OPERATION_STATE_SUCCEEDED');
}

async function checkDrag(page, { frames }) {
  const before = await storedSegments();
  const duration = frames.length / kRate;
  assert.deepEqual(
    before.map(({ label }) => label),
    ['jump'],
  );
  await page.locator('.segment-body', { hasText: 'jump' }).press('Enter');
  await recordProgress(page);
  await page.locator('.timeline').evaluate((node) => node.scrollIntoView({ block: 'center' }));
  const lanes = await page.locator('.lanes').boundingBox();
  const edge = await page.locator('.edge.end').boundingBox();
  const y = edge.y + edge.height / 2;
  await page.mouse.move(edge.x + 3, y); // the rest is beyond the end of the clip
  await page.mouse.down();
  await page.mouse.move(lanes.x + 0.7 * lanes.width, y, { steps: 3 });
  await page.mouse.move(lanes.x + 0.613 * lanes.width, y);
  // While it moves, the motion shows its place, and nothing is stored.
  const end = Math.round(0.613 * duration * kRate);
  await page.locator('.position', { hasText: `frame ${end}` }).waitFor();
  assert.deepEqual(await storedSegments(), before);
  await page.mouse.up();
  await checkProgress(page);
  const [moved] = await storedSegments();
  assert.ok(Math.abs(moved.end - end / kRate) < 1e-6, `end at ${moved.end} s`);
  assert.equal(moved.start, before[0].start);
  const width = async () => (await page.locator('.segment').boundingBox()).width / lanes.width;
  assert.ok(Math.abs((await width()) - end / kRate / duration) < 0.01);
  const undo = await page.getByRole('button', { name: 'Undo last edit' }).boundingBox();
  await page.mouse.click(undo.x + undo.width / 2, undo.y + undo.height / 2);
  await page.locator('.edge.end[aria-valuenow="2.000"]').waitFor();
  assert.deepEqual(await storedSegments(), before);
  assert.ok((await width()) > 0.99);
  await checkProgress(page);
}

test('stages, curves and segments of a clip are those of the server', async (t) => {
  await storeKnown();
  const first = await motionOf(setup.open, kClip);
  const second = await motionOf(setup.open, 'databases/known/clips/jump_c');
  const page = await newPage(t, { viewport: { width: 1000, height: 900 } });
  await recordDrawing(page);
  await recordCharts(page);
  const query = 'with=jump_c&offset=0.25&t=0.5&show=markers&point=LHand';
  await page.goto(`${setup.open}/#/clip/known/jump_b?${query}`);
  await t.test('two stages', () => checkStages(page, first, second));
  await t.test('curves', () => checkCurves(page, first));
  await t.test('a segment is dragged, and the edit undone', () => checkDrag(page, first));
});
