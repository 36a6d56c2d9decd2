// The list of clips: filter, facets, search, order, upload with its mapping.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, drop, newPage, shown } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, motionOf, stream } from './support/stream.mjs';

const filterInput = '.filter input >> nth=0';

async function openClips(t, options) {
  const page = await newPage(t, options);
  await page.goto(`${setup.open}/#/clips/demo`);
  await shown(page);
  await page.locator('table.clips tbody tr').first().waitFor();
  return page;
}

test('a facet filters the list, and the address keeps the filter', async (t) => {
  const page = await openClips(t);
  await page.locator('.facet', { hasText: 'boxing' }).click();
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
  assert.equal(await page.inputValue(filterInput), 'label = boxing');
  await page.waitForURL(/filter=/);
  const address = page.url();
  await page.goto('about:blank');
  await page.goto(address);
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
});

// Bones of five poses side by side on a picture, as the server's positions give them.
async function bonesOfThumbnail(clip, width, height) {
  const { body } = await call(setup.open, 'ClipService/GetClip', { name: clip });
  const stride = Math.floor(body.clip.frameCount / 5);
  const firstFrame = Math.floor(stride / 2);
  const { bones, frames } = await motionOf(setup.open, clip, { firstFrame, stride });
  const poses = frames.slice(0, 5);
  const top = Math.max(...poses.flatMap((pose) => pose.filter((_, i) => i % 3 === 2)));
  const scale = (0.92 * height) / top;
  return poses.flatMap((pose, column) => {
    const across = (point) => 0.8 * pose[3 * point] - 0.6 * pose[3 * point + 1];
    const places = Array.from({ length: pose.length / 3 }, (_, point) => across(point));
    const middle = places.reduce((sum, value) => sum + value, 0) / places.length;
    const at = (point) => [
      ((column + 0.5) * width) / 5 + (across(point) - middle) * scale,
      0.97 * height - pose[3 * point + 2] * scale,
    ];
    return bones.map(({ fromPoint = 0, toPoint = 0 }) => [at(fromPoint), at(toPoint)]);
  });
}

test('a thumbnail shows poses of the clip, in the colours of the theme', async (t) => {
  const page = await openClips(t, { colorScheme: 'light' });
  const row = page.locator('table.clips tbody tr', {
    has: page.getByRole('link', { name: '01_01' }),
  });
  // Colour of each painted pixel, with its place.
  const painted = () =>
    row.locator('canvas.thumbnail').evaluate((canvas) => {
      const { width, height } = canvas;
      const copy = Object.assign(document.createElement('canvas'), { width, height });
      const context = copy.getContext('2d', { willReadFrequently: true });
      context.drawImage(canvas, 0, 0);
      const { data } = context.getImageData(0, 0, width, height);
      const pixels = Array.from({ length: width * height }, (_, i) => [
        i % width,
        Math.floor(i / width),
      ]);
      return {
        width,
        height,
        pixels: pixels
          .map(([x, y], i) => [x + 0.5, y + 0.5, ...data.subarray(4 * i, 4 * i + 4)])
          .filter((pixel) => pixel[5] > 0),
      };
    });
  const waitUntil = async (what, holds) => {
    const end = performance.now() + 20_000;
    for (;;) {
      const picture = await painted();
      if (holds(picture)) return picture;
      assert.ok(performance.now() < end, what);
      await page.waitForTimeout(50);
    }
  };
  const { width, height, pixels } = await waitUntil('a picture', ({ pixels }) => pixels.length > 0);
  const bones = await bonesOfThumbnail('databases/demo/clips/01_01', width, height);
  const distanceTo = ([x, y], [[x0, y0], [x1, y1]]) => {
    const [dx, dy] = [x1 - x0, y1 - y0];
    const along = ((x - x0) * dx + (y - y0) * dy) / Math.max(dx * dx + dy * dy, 1e-9);
    const part = Math.min(1, Math.max(0, along));
    return Math.hypot(x - x0 - part * dx, y - y0 - part * dy);
  };
  for (const pixel of pixels) {
    const nearest = Math.min(...bones.map((bone) => distanceTo(pixel, bone)));
    assert.ok(nearest < 1.5, `pixel ${pixel} is ${nearest} px from a bone`);
  }
  for (const [[x0, y0], [x1, y1]] of bones) {
    const middle = [(x0 + x1) / 2, (y0 + y1) / 2];
    const near = pixels.some(([x, y]) => Math.hypot(x - middle[0], y - middle[1]) < 1.5);
    assert.ok(near, `bone at ${middle} is painted`);
  }
  // The grey of the light theme is darker than that of the dark theme.
  const lightness = ({ pixels }) => {
    const strong = pixels.filter((pixel) => pixel[5] > 200);
    return strong.reduce((sum, pixel) => sum + pixel[3], 0) / strong.length;
  };
  const before = lightness({ pixels });
  await page.emulateMedia({ colorScheme: 'dark' });
  await waitUntil('a lighter picture', (picture) => lightness(picture) > before + 40);
});

test('a narrow window scrolls the table, not the page', async (t) => {
  const page = await openClips(t, { viewport: { width: 400, height: 800 } });
  const widths = await page.evaluate(() => ({
    page: document.documentElement.scrollWidth,
    table: document.querySelector('table.clips').clientWidth,
  }));
  assert.ok(widths.table > 400, `table of ${widths.table} px`);
  assert.equal(widths.page, 400);
});

test('headings sort, the search finds words, and an error of the filter shows its place', async (t) => {
  const page = await openClips(t, { expected: [/400 \(Bad Request\)/] });
  await page.locator('button.sort', { hasText: 'Duration' }).click();
  await page.locator('th[aria-sort=ascending]', { hasText: 'Duration' }).waitFor();
  await page.fill('.filter input >> nth=1', 'boxing');
  await page.press('.filter input >> nth=1', 'Enter');
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
  // The values are those of the found clip.
  const counts = await page.locator('.facets .facet-count').allTextContents();
  assert.deepEqual([...new Set(counts)], [' 1']);
  await page.fill(filterInput, 'lable = walk');
  await page.press(filterInput, 'Enter');
  assert.equal(await page.textContent('.filter-error mark'), 'lable = walk');
  await checkAccessibility(page);
});

test('a change of another client does not disturb who corrects a filter', async (t) => {
  const page = await openClips(t, { expected: [/400 \(Bad Request\)/] });
  await page.fill(filterInput, 'label = = boxing');
  await page.press(filterInput, 'Enter');
  await page.locator('.filter-error').waitFor();
  await page.fill(filterInput, 'label = box');
  await page.locator('.filter-error').evaluate((node) => (node.dataset.seen = 'yes'));
  await call(setup.open, 'ClipService/UpdateClip', {
    clip: { name: 'databases/demo/clips/01_03', title: 'Changed elsewhere' },
    updateMask: 'title',
  });
  // The list is read again, with the filter that was applied.
  await page.locator('.filter-error:not([data-seen])', { hasText: 'label = = boxing' }).waitFor();
  await page.keyboard.type('ing');
  assert.equal(await page.inputValue(filterInput), 'label = boxing');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
});

// The points of a file as the server reads it, with the markers that are computed from each.
async function inspect(parent, fileName, buffer) {
  const header = { parent, fileName, validateOnly: true };
  const request = { header, file: buffer.toString('base64') };
  const { status, body } = await call(setup.open, 'ClipService/UploadClip', request);
  assert.equal(status, 200, JSON.stringify(body));
  return body;
}

// The figure of a mapping has all points, the used ones in one colour and the others in another.
// `highlighted`: a point in a third colour.
async function checkPoints(page, points, highlighted = '') {
  const places = points.flatMap(({ xM = 0, yM = 0, zM = 0 }) => [xM, yM, zM]);
  await whenDrawn(page, '.mapping canvas', (drawn) => {
    const figure = drawn.find((each) => distance(placesOfInstances(each), places) < 1e-4);
    assert.ok(figure, 'points of the file');
    const colors = points.map((_, i) => String(figure.instanceColors.slice(3 * i, 3 * i + 3)));
    const kinds = points.map(({ name, markerNames = [] }) =>
      name === highlighted ? 'highlighted' : markerNames.length > 0 ? 'used' : 'unused',
    );
    const pairs = new Set(points.map((_, i) => `${kinds[i]} ${colors[i]}`));
    assert.equal(pairs.size, new Set(kinds).size, [...pairs].join('; '));
    assert.equal(new Set(colors).size, pairs.size);
  });
}

// Uploads a part of a recording to a new database in a page. Returns the page when it shows the mapping,
// and what the server finds in the file: `checked`, and `checkAgain` after a change.
async function uploadPart(t, database, fileName, recording, first, end) {
  const parent = `databases/${database}`;
  await call(setup.open, 'DatabaseService/CreateDatabase', { databaseId: database });
  const motion = await readBvh(recording);
  const buffer = Buffer.from(bvhOf(motion, motion.rows.slice(first, end)));
  const checkAgain = () => inspect(parent, fileName, buffer);
  const checked = await checkAgain();
  const page = await newPage(t, { viewport: { width: 900, height: 700 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/clips/${database}`);
  await page.setInputFiles('input[type=file]', { name: fileName, mimeType: 'text/plain', buffer });
  await page.locator('.mapping p', { hasText: `Mapping: ${checked.mapping}.` }).waitFor();
  return { page, parent, checked, checkAgain };
}

test('an edited rule of an uploaded file changes its figure and the stored clip', async (t) => {
  const upload = await uploadPart(t, 'mapped', 'part.bvh', '01_03', 600, 900);
  const { page, parent, checked: before } = upload;
  await checkPoints(page, before.points);
  await page.getByLabel('Rule of Waist', { exact: true }).focus();
  await checkPoints(page, before.points, 'Spine');
  // Fewer points than the mapping of the marker set, which fits too.
  const rules = { Waist: 'LowerBack', LHand: 'LeftForeArm' };
  for (const [marker, rule] of Object.entries(rules))
    await page.getByLabel(`Rule of ${marker}`, { exact: true }).fill(rule);
  const store = page.locator('.upload-item').getByRole('button', { name: 'Store' });
  await page.getByText('The edited rules of the mapping are not used yet').waitFor();
  assert.ok(await store.isDisabled());
  await page.getByRole('button', { name: 'Use these rules' }).click();
  await page.locator('.mapping p', { hasText: 'Mapping: page-part.' }).waitFor();
  const after = await upload.checkAgain();
  const usedPoints = ({ points }) =>
    new Set(points.filter(({ markerNames }) => markerNames).map(({ name }) => name));
  const expected = usedPoints(before);
  expected.delete('Spine');
  assert.deepEqual(usedPoints(after), expected.add('LowerBack'));
  await checkPoints(page, after.points);
  assert.equal(await page.getByLabel('Rule of Waist', { exact: true }).inputValue(), '1 LowerBack');
  await store.click();
  await page.getByText('stored as').waitFor();
  const [stored] = await stream(setup.open, 'ViewService/ReadClipMotion', {
    name: `${parent}/clips/part`,
    joints: true,
  });
  const placesOf = (names, positions, name) =>
    floatsOf(positions).filter((_, i) => Math.floor(i / 3) % names.length === names.indexOf(name));
  const { markerNames, jointNames } = stored.figure;
  for (const [marker, joint] of Object.entries(rules)) {
    const markers = placesOf(markerNames, stored.markerPositions, marker);
    const apart = distance(markers, placesOf(jointNames, stored.jointPositions, joint));
    assert.ok(markers.length > 100 && apart < 1e-4, `${marker} is ${apart} m from ${joint}`);
  }
});

test('a folder of files is checked without a picture for each', async (t) => {
  const parent = 'databases/folder';
  await call(setup.open, 'DatabaseService/CreateDatabase', { databaseId: 'folder' });
  const page = await newPage(t, { viewport: { width: 900, height: 700 } });
  await page.goto(`${setup.open}/#/clips/folder`);
  await shown(page);
  const motion = await readBvh('01_01');
  const files = Array.from({ length: 20 }, (_, i) => ({
    name: `part_${i}.bvh`,
    mimeType: 'text/plain',
    buffer: Buffer.from(bvhOf(motion, motion.rows.slice(20 * i, 20 * i + 60))),
  }));
  await page.setInputFiles('input[type=file]', files);
  const items = page.locator('.upload-item');
  await items
    .locator('.hint', { hasText: /^checked$/ })
    .nth(19)
    .waitFor();
  assert.equal(await page.locator('.mapping').count(), 0);
  const canvases = page.locator('.mapping canvas');
  const rule = (item) => item.getByLabel('Rule of Waist', { exact: true });
  await items.nth(7).locator('summary').click();
  await rule(items.nth(7)).waitFor();
  assert.equal(await canvases.count(), 1);
  await rule(items.nth(7)).fill('LowerBack');
  // A closed mapping keeps its rules, not its picture: a browser has few.
  await items.nth(7).locator('summary').click();
  await canvases.waitFor({ state: 'detached' });
  await items.nth(7).locator('summary').click();
  await canvases.waitFor();
  assert.equal(await rule(items.nth(7)).inputValue(), 'LowerBack');
  await page.getByRole('button', { name: 'Reset rules' }).click();
  await page.getByRole('button', { name: 'Store all checked clips' }).click();
  await items.getByText('stored as').nth(19).waitFor();
  const { body } = await call(setup.open, 'ClipService/ListClips', { parent });
  assert.equal(body.clips.length, 20);
});

test('a dropped file is stored, and the page shows the update of the model', async (t) => {
  await call(setup.open, 'DatabaseService/CreateDatabase', { databaseId: 'dropped' });
  const page = await newPage(t, { viewport: { width: 900, height: 700 } });
  await page.goto(`${setup.open}/#/clips/dropped`);
  await shown(page);
  await page.getByText('0 clips').waitFor();
  const motion = await readBvh('01_03');
  await drop(
    page.locator('body'),
    'part.bvh',
    Buffer.from(bvhOf(motion, motion.rows.slice(0, 400))),
  );
  const item = page.locator('.upload-item');
  await item.getByLabel('Label').fill('climb');
  const store = item.getByRole('button', { name: 'Store' });
  await page.evaluate(() => {
    const operation = document.querySelector('.operation');
    window.progress = [];
    new MutationObserver(() => {
      const [bar, text] = [operation.querySelector('progress'), operation.querySelector('.hint')];
      window.progress.push([operation.hidden || bar.hidden, bar.value, text.textContent]);
    }).observe(operation, { attributes: true, childList: true, subtree: true });
  });
  await store.click();
  await item.getByText('stored as').waitFor();
  const row = page.locator('table.clips tbody tr');
  await row.getByRole('link', { name: 'part' }).waitFor();
  assert.match(await row.textContent(), /climb/);
  await page.locator('.operation', { hasText: 'Model is up to date.' }).waitFor();
  const progress = await page.evaluate(() => window.progress);
  const values = progress.flatMap(([hidden, value, text]) => {
    if (hidden) return [];
    const shownValue = /^Model: .*, (\d+) %$/.exec(text)?.[1];
    assert.ok(Math.abs(Number(shownValue) - 100 * value) < 1, `${text} beside ${value}`);
    return [value];
  });
  assert.ok(values.length > 0, JSON.stringify(progress));
  assert.deepEqual(
    values,
    [...values].sort((a, b) => a - b),
  );
  assert.equal(progress.at(-1)[0], true, 'no bar of an operation that is done');
  const { body } = await call(setup.open, 'ModelService/GetModel', {
    name: 'databases/dropped/models/current',
  });
  assert.equal(body.model.clipCount, 1, JSON.stringify(body));
});

// Rules of markers in the text of a mapping; as the table of a file shows them.
function rulesIn(mappingText) {
  const lines = mappingText.trimEnd().split('\n');
  return lines.filter((line) => line.includes(' = ')).map((line) => line.split(' = '));
}

function shownRules(item) {
  return item
    .locator('.rules tbody tr')
    .evaluateAll((rows) =>
      rows.map((row) => [row.querySelector('th').textContent, row.querySelector('input').value]),
    );
}

test('the rules of an automatic mapping are those of the server, and can be stored', async (t) => {
  const upload = await uploadPart(t, 'rigged', 'box.bvh', 'Boxing_Toes', 600, 800);
  const { page, checked: automatic } = upload;
  const item = page.locator('.upload-item');
  await item.getByLabel('Rule of Waist', { exact: true }).waitFor({ state: 'attached' });
  const rules = await shownRules(item);
  // Some markers are offset from a joint or between joints, with weights of the server.
  assert.ok(rules.filter(([, rule]) => !rule.startsWith('1 ')).length > 3, JSON.stringify(rules));
  assert.deepEqual(rules, rulesIn(automatic.mappingText));
  await item.getByRole('button', { name: 'Use these rules' }).click();
  await item.locator('.mapping p', { hasText: 'Mapping: page-box.' }).waitFor();
  const stored = await upload.checkAgain();
  assert.equal(stored.mapping, 'page-box');
  assert.deepEqual(rulesIn(stored.mappingText), rules);
  assert.deepEqual(stored.points, automatic.points);
});
