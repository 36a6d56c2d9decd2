// The player of a clip: positions, segments, speed of drawing, memory.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { project } from './support/projection.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { markersAt, motionOf } from './support/stream.mjs';
import { fingersOf, tapOf } from './support/touch.mjs';

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
    numbers.forEach((text, axis) =>
      assert.ok(Math.abs(Number(text) - point[axis]) < 6e-4, shownText),
    );
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
    (text) =>
      ![...document.querySelectorAll('.segment-body')].some(
        (node) => node.getAttribute('aria-label') === text,
      ),
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

test('the zoom of the timeline and the selected segment are in the address', async (t) => {
  const page = await openClip(t, 't=1&zoom=much');
  const zoom = page.getByLabel('Zoom');
  assert.equal(await zoom.inputValue(), '1');
  await zoom.fill('8');
  await page.locator('.segment-body').first().click();
  await page.waitForURL(/zoom=8.*segment=./);
  const label = await page.locator('.segment-body[aria-pressed=true]').getAttribute('aria-label');
  await page.reload();
  await page.locator('.segment-body[aria-pressed=true]').waitFor();
  assert.equal(
    await page.locator('.segment-body[aria-pressed=true]').getAttribute('aria-label'),
    label,
  );
  assert.equal(await zoom.inputValue(), '8');
  // The present time is visible.
  const { left, right, at } = await page.evaluate(() => {
    const { left, right } = document.querySelector('.timeline').getBoundingClientRect();
    return { left, right, at: document.querySelector('.playhead').getBoundingClientRect().left };
  });
  assert.ok(left <= at && at <= right, `${at} in ${left} to ${right}`);
  await page.locator('.segment-body[aria-pressed=true]').click();
  await page.waitForURL((url) => !url.href.includes('segment='));
});

test('fingers use the player, the timeline and the curves', async (t) => {
  const page = await openClip(t, '', { hasTouch: true });
  const [touch, tapAt] = [await fingersOf(page), await tapOf(page)];
  const frames = Number(await page.getByLabel('Frame', { exact: true }).getAttribute('max'));
  // The browser makes a click of a tap after the tap has returned.
  const waitForFrame = (fraction) =>
    page.waitForFunction(
      (expected) => {
        const [, frame] = document.querySelector('.position').textContent.match(/frame (\d+)/);
        return Math.abs(frame - expected.frame) < expected.tolerance;
      },
      { frame: fraction * frames, tolerance: 0.03 * frames },
    );
  const tap = async (locator, fraction, top) => {
    await locator.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await locator.boundingBox();
    await tapAt(x + fraction * width, y + (top ?? height / 2));
    await waitForFrame(fraction);
  };
  await tap(page.getByLabel('Frame', { exact: true }), 0.5);
  await tap(page.locator('.timeline .lanes'), 0.25, 4);
  await tap(page.locator('.chart .u-over'), 0.75);

  // Two fingers zoom the curves; what is under them stays there.
  const plot = await page.locator('.chart .u-over').boundingBox();
  const middle = plot.y + plot.height / 2;
  const fingers = (half) =>
    [-half, half].map((each) => [plot.x + plot.width * (0.5 + each), middle]);
  await touch([0.1, 0.15, 0.2].map(fingers));
  await tapAt(plot.x + plot.width / 4, middle);
  await waitForFrame(0.375);

  await page.fill('.segment-form input >> nth=0', 'touch');
  await page.fill('.segment-form input >> nth=1', 'tapped');
  await page.getByRole('button', { name: 'Add segment from here' }).click();
  const edge = page.locator('.edge.end');
  await edge.waitFor();
  await edge.scrollIntoViewIfNeeded();
  const { x, y, width, height } = await edge.boundingBox();
  const lanes = await page.locator('.timeline .lanes').boundingBox();
  const end = lanes.x + 0.6 * lanes.width;
  const change = page.waitForResponse(/SegmentService\/UpdateSegment/);
  await touch([x + width / 2, (x + end) / 2, end].map((left) => [[left, y + height / 2]]));
  await change;
  // The answer draws edge and form again, with another button.
  await page.waitForFunction(() => {
    const edge = document.querySelector('.edge.end');
    const seconds = Number(edge.getAttribute('aria-valuenow'));
    return (
      Math.abs(seconds / Number(edge.getAttribute('aria-valuemax')) - 0.6) < 0.02 &&
      Math.abs(Number(document.querySelector('.segment-form [data-key=end]').value) - seconds) <
        2e-3
    );
  });
  await page.getByRole('button', { name: 'Delete' }).click();
  await edge.waitFor({ state: 'detached' });
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
  const joints = await page
    .locator('option[value^="joint:"]')
    .evaluateAll((options) => options.map((option) => option.value.slice('joint:'.length)));
  assert.ok(names.size > 0);
  for (const name of names) assert.ok(joints.includes(name), name);
  // Without both, nothing is named.
  await page.getByLabel('Recorded skeleton').uncheck();
  for (let y = 0.2; y < 0.8; y += 0.04) {
    await page.mouse.move(box.x + box.width / 2, box.y + y * box.height);
    assert.equal(await page.locator('.scene .overlay:visible').count(), 0);
  }
});

test('without WebGL the player, segments and curves work', async (t) => {
  const page = await newPage(t);
  await disableWebGL(page);
  await page.goto(`${setup.open}/#/clip/demo/01_01`);
  await page.locator('.chart canvas').waitFor();
  await page.getByRole('button', { name: 'Play' }).click();
  await page.waitForFunction(() =>
    /frame [1-9]/.test(document.querySelector('.position').textContent),
  );
});

// Calls the server as another client.
async function callAsOther(method, request) {
  const { status, body } = await call(setup.open, method, request);
  assert.equal(status, 200, JSON.stringify(body));
  return body;
}

// Stores frames of a recording as the clip `part` of the database `replaced`.
async function storePart(recording, first, end, header = {}) {
  const file = Buffer.from(bvhOf(recording, recording.rows.slice(first, end)));
  return callAsOther('ClipService/UploadClip', {
    header: { parent: 'databases/replaced', fileName: 'part.bvh', clipId: 'part', ...header },
    file: file.toString('base64'),
  });
}

// The player has the stored motion and shows its frame 30. Returns the positions in this frame.
async function checkMotion(page) {
  const { frames } = await motionOf(setup.open, 'databases/replaced/clips/part');
  const slider = page.getByLabel('Frame', { exact: true });
  await page.locator('.position', { hasText: /frame 30$/ }).waitFor();
  assert.equal(Number(await slider.getAttribute('max')), frames.length - 1);
  await whenDrawn(page, '.scene canvas', (drawn) => {
    const nearest = Math.min(...drawn.map((each) => distance(placesOfInstances(each), frames[30])));
    assert.ok(nearest < 1e-4, `${nearest} m away`);
  });
  return frames[30];
}

test('a clip that is replaced or derived again while it is open can be loaded', async (t) => {
  await callAsOther('DatabaseService/CreateDatabase', { databaseId: 'replaced' });
  const recording = await readBvh('01_03');
  await storePart(recording, 0, 400);
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/clip/replaced/part?t=0.5&show=markers`);
  await checkMotion(page);
  // An edit leaves the motion.
  await page.getByText('Properties', { exact: true }).click();
  await callAsOther('ClipService/UpdateClip', {
    clip: { name: 'databases/replaced/clips/part', title: 'Edited elsewhere' },
    updateMask: 'title',
  });
  await page.locator('dd', { hasText: 'Edited elsewhere' }).waitFor();
  const load = page.getByRole('button', { name: 'Load the new motion' });
  assert.equal(await load.count(), 0);

  await storePart(recording, 600, 900, { replace: true });
  await load.click();
  const replaced = await checkMotion(page);
  assert.equal(await load.count(), 0);

  // Another mapping changes the motion, and neither its frames nor the time when it was stored.
  const check = { replace: true, validateOnly: true };
  const { points, mappingText } = await storePart(recording, 600, 900, check);
  const rules = mappingText.split('\n').filter((line) => line.includes(' = '));
  await callAsOther('MarkerSetService/AddMappings', {
    database: 'databases/replaced',
    mappingFile: [
      'motiondb-marker-set 1',
      'mapping other',
      `signature ${points.map(({ name }) => name).join(' ')}`,
      ...rules.map((rule) => rule.replace(/^Waist = .*/, 'Waist = LowerBack')),
      '',
    ].join('\n'),
  });
  // The list draws its picture again, and the second of two clips offers its new motion, too.
  const list = await newPage(t);
  const read = () => list.waitForResponse(/ReadClipMotion/);
  await Promise.all([read(), list.goto(`${setup.open}/#/clips/replaced`)]);
  const drawnAgain = read();
  const pair = await newPage(t, { viewport: { width: 700, height: 500 } });
  await pair.goto(`${setup.open}/#/clip/replaced/part?show=markers&with=part`);
  await pair.getByRole('button', { name: 'Align' }).and(pair.locator(':enabled')).waitFor();
  await callAsOther('DatabaseService/ReprocessDatabase', { name: 'databases/replaced' });
  await load.click();
  assert.ok(distance(await checkMotion(page), replaced) > 0.01);
  await drawnAgain;
  const loadSecond = pair.getByRole('button', { name: 'Load the new motion of the second clip' });
  await loadSecond.click();
  await loadSecond.waitFor({ state: 'detached' });
  await pair.getByRole('button', { name: 'Align' }).and(pair.locator(':enabled')).waitFor();
  assert.equal(await pair.locator('.motion-pane').count(), 2);
});
