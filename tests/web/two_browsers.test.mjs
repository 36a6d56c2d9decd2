// Two clients change the same clip: each sees the changes of the other, and nothing is lost.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, shown } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { failedStream } from './support/stream.mjs';

const clip = 'databases/demo/clips/01_03';
const conflict = { expected: [/status of 409/], viewport: { width: 700, height: 400 } };

async function openClip(t, options) {
  const page = await newPage(t, options);
  await page.goto(`${setup.open}/#/clip/demo/01_03?show=markers`);
  await shown(page);
  await page.locator('.segment').first().waitFor();
  return page;
}

async function stored() {
  return (await call(setup.open, 'ClipService/GetClip', { name: clip })).body.clip;
}

test('two browsers edit the same segment', async (t) => {
  const { body } = await call(setup.open, 'SegmentService/CreateSegment', {
    parent: clip,
    segment: { track: 'duo', label: 'before', startSeconds: 0, endSeconds: 1 },
  });
  const first = await openClip(t);
  const second = await openClip(t, conflict);
  const label = (page) => page.locator('.segment-form').getByLabel('Label');
  for (const page of [first, second])
    await page.locator('.segment-body', { hasText: 'before' }).press('Enter');
  await label(second).fill('of the second');
  await label(first).fill('of the first');
  await label(first).press('Enter');
  // The second has input that is not saved: it stays, and the change of the first is reported.
  await second.getByText('Another client has changed the segments').waitFor();
  assert.equal(await label(second).inputValue(), 'of the second');
  await label(second).press('Enter');
  await second.locator('.notice.error').waitFor();
  const { name } = body.segment;
  const { body: list } = await call(setup.open, 'SegmentService/ListSegments', { parent: clip });
  assert.equal(list.segments.find((each) => each.name === name).label, 'of the first');
  await second.getByRole('button', { name: 'Load the stored segments' }).click();
  await second.locator('.segment-body', { hasText: 'of the first' }).waitFor();
  // Without such input the change of the other appears by itself.
  await first.getByRole('button', { name: 'Delete', exact: true }).click();
  await second.locator('.segment-body', { hasText: 'of the first' }).waitFor({ state: 'detached' });
});

test('two browsers edit the properties of a clip', async (t) => {
  const pages = [await openClip(t), await openClip(t, conflict)];
  const [first, second] = pages;
  for (const page of pages) {
    await page.getByText('Properties', { exact: true }).click();
    await page.getByRole('button', { name: 'Edit', exact: true }).press('Enter');
  }
  await first.getByLabel('Title').fill('Title of the first');
  await first.getByLabel('Tags').fill('indoor, slow');
  await first.getByLabel('Title').press('Enter');
  await first.locator('dd', { hasText: 'indoor, slow' }).waitFor();
  await second.getByLabel('Title').fill(setup.hostile);
  await second.getByRole('button', { name: 'Add field' }).click();
  await second.getByRole('textbox', { name: 'Field', exact: true }).fill('mass');
  await second.getByLabel('Kind').selectOption('number');
  await second.getByLabel('Value').fill('7.5');
  await second.getByRole('button', { name: 'Save', exact: true }).last().click();
  await second.getByText('Nothing is saved: another client has changed the clip').waitFor();
  await second.locator('dd', { hasText: 'Title of the first' }).waitFor();
  assert.equal((await stored()).title, 'Title of the first');
  await second.getByRole('button', { name: 'Save', exact: true }).last().click();
  // The properties of the first page follow.
  await first.locator('dd', { hasText: setup.hostile }).waitFor();
  const { title, tags, fields } = await stored();
  assert.deepEqual(
    { title, tags, fields },
    { title: setup.hostile, tags: ['indoor', 'slow'], fields: { mass: { number: 7.5 } } },
  );
  assert.equal(await second.evaluate(() => window.hacked), undefined);
});

test('the list of clips shows a change of another client', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/clips/demo`);
  const link = page.getByRole('link', { name: '01_03' });
  await link.focus();
  await call(setup.open, 'ClipService/UpdateClip', {
    clip: { name: clip, title: 'Title from elsewhere' },
    updateMask: 'title',
  });
  await page.locator('td', { hasText: 'Title from elsewhere' }).waitFor();
  assert.ok(await link.evaluate((node) => node === document.activeElement));
});

test('a view that cannot follow changes shows why, until it can', async (t) => {
  const page = await newPage(t);
  const watches = '**/motiondb.v1.DatabaseService/WatchDatabase';
  await page.route(watches, (route) =>
    route.fulfill(failedStream('resource_exhausted', 'too many streams')),
  );
  for (const place of ['clips/demo', 'clip/demo/01_03']) {
    await page.goto(`${setup.open}/#/${place}`);
    await page.getByText('Changes of others are not shown: too many streams').waitFor();
  }
  await page.unroute(watches);
  await page.getByText('Changes of others').waitFor({ state: 'detached' });
});
