// Parts of the page that a user opens, in both themes: axe reports nothing. The stored choice of the
// theme.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage, shown } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const kParent = 'databases/states';

async function callAsOther(method, request) {
  const { status, body } = await call(setup.open, method, request);
  assert.equal(status, 200, JSON.stringify(body));
  return body;
}

let stored;

// The database `states` with the clips `one` and `two`, and the file of another one.
function storeClips() {
  stored ??= store();
  return stored;
}

async function store() {
  await callAsOther('DatabaseService/CreateDatabase', { databaseId: 'states' });
  const recording = await readBvh('01_03');
  const part = (first) => Buffer.from(bvhOf(recording, recording.rows.slice(first, first + 200)));
  for (const [i, clipId] of ['one', 'two'].entries())
    await callAsOther('ClipService/UploadClip', {
      header: { parent: kParent, fileName: `${clipId}.bvh`, clipId, label: 'climb' },
      file: part(600 + 200 * i).toString('base64'),
    });
  return { name: 'three.bvh', mimeType: 'text/plain', buffer: part(1000) };
}

async function openClip(t, options, query = '') {
  await storeClips();
  const page = await newPage(t, { expected: [/status of 409/], ...options });
  await page.goto(`${setup.open}/#/clip/states/one?${query}`);
  await shown(page);
  await page.locator('.chart canvas').waitFor();
  return page;
}

for (const colorScheme of ['light', 'dark']) {
  const check = (name, call) => test(`axe: ${name} in the ${colorScheme} theme`, call);

  check('an upload with its mapping', async (t) => {
    const file = await storeClips();
    const page = await newPage(t, { colorScheme });
    await page.goto(`${setup.open}/#/clips/states`);
    await page.setInputFiles('input[type=file]', file);
    const rule = page.getByLabel('Rule of Waist', { exact: true });
    await page.locator('.mapping p', { hasText: 'Mapping: ' }).waitFor();
    await rule.waitFor();
    await checkAccessibility(page);
    await rule.fill('LowerBack');
    await page.getByText('The edited rules of the mapping are not used yet').waitFor();
    await checkAccessibility(page);
  });

  check('the form of a clip and its conflict', async (t) => {
    const page = await openClip(t, { colorScheme });
    await page.getByText('Properties', { exact: true }).click();
    await page.getByRole('button', { name: 'Edit', exact: true }).press('Enter');
    await page.getByRole('button', { name: 'Add field' }).click();
    await page.getByLabel('Title').fill(`of the page, ${colorScheme}`);
    await checkAccessibility(page);
    await callAsOther('ClipService/UpdateClip', {
      clip: { name: `${kParent}/clips/one`, title: `from elsewhere, ${colorScheme}` },
      updateMask: 'title',
    });
    await page.getByLabel('Title').press('Enter');
    await page.getByText('Nothing is saved: another client has changed the clip').waitFor();
    await checkAccessibility(page);
  });

  check('two clips side by side', async (t) => {
    const page = await openClip(t, { colorScheme }, 'with=two');
    await page.locator('.motion-pane:nth-child(2) canvas').waitFor();
    await page.getByRole('button', { name: 'Align', disabled: false }).waitFor();
    await checkAccessibility(page);
  });

  check('a conflict of segments', async (t) => {
    await storeClips();
    const label = `shared ${colorScheme}`;
    const { segment } = await callAsOther('SegmentService/CreateSegment', {
      parent: `${kParent}/clips/one`,
      segment: { track: colorScheme, label, startSeconds: 0, endSeconds: 1 },
    });
    const page = await openClip(t, { colorScheme });
    await page.locator('.segment-body', { hasText: label }).press('Enter');
    const input = page.locator('.segment-form').getByLabel('Label');
    await input.fill('of the page');
    await callAsOther('SegmentService/UpdateSegment', {
      segment: { ...segment, label: 'from elsewhere' },
      updateMask: 'label',
    });
    await page.getByText('Another client has changed the segments').waitFor();
    await checkAccessibility(page);
    await input.press('Enter');
    await page.locator('.notice.error').waitFor();
    await checkAccessibility(page);
  });
}

test('the theme that a user chooses stays after a reload', async (t) => {
  const page = await newPage(t, { colorScheme: 'light' });
  await page.goto(`${setup.open}/#/clips/demo`);
  await page.locator('table.clips tbody tr').first().waitFor();
  const theme = () =>
    page.evaluate(() => ({
      name: document.documentElement.dataset.theme,
      background: getComputedStyle(document.body).backgroundColor,
      text: getComputedStyle(document.body).color,
    }));
  const brightness = (color) => color.match(/\d+/g).reduce((sum, part) => sum + Number(part), 0);
  const light = await theme();
  assert.equal(light.name, 'light');
  assert.ok(brightness(light.background) > brightness(light.text));
  await page.getByRole('button', { name: 'Dark', exact: true }).click();
  const dark = await theme();
  assert.equal(dark.name, 'dark');
  assert.ok(brightness(dark.background) < brightness(dark.text));
  await checkAccessibility(page);
  await page.reload();
  await page.locator('table.clips tbody tr').first().waitFor();
  assert.deepEqual(await theme(), dark);
  await page.getByRole('button', { name: 'Light', exact: true }).click();
  assert.deepEqual(await theme(), light);
  await page.reload();
  await page.locator('table.clips tbody tr').first().waitFor();
  assert.deepEqual(await theme(), light);
});
