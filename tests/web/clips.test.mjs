// The list of clips: filter, facets, search, order, upload with its mapping.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { checkAccessibility, newPage, shown } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

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
  const address = page.url();
  await page.goto('about:blank');
  await page.goto(address);
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
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

test('an error of the filter shows its place', async (t) => {
  const page = await openClips(t, { expected: [/400 \(Bad Request\)/] });
  await page.fill(filterInput, 'lable = walk');
  await page.press(filterInput, 'Enter');
  assert.equal(await page.textContent('.filter-error mark'), 'lable = walk');
  await checkAccessibility(page);
});

test('headings sort, and the search finds words', async (t) => {
  const page = await openClips(t);
  await page.locator('button.sort', { hasText: 'Duration' }).click();
  await page.locator('th[aria-sort=ascending]', { hasText: 'Duration' }).waitFor();
  await page.fill('.filter input >> nth=1', 'boxing');
  await page.press('.filter input >> nth=1', 'Enter');
  await page.waitForFunction(() => document.querySelectorAll('table.clips tbody tr').length === 1);
});

test('an uploaded file shows its mapping, which can be changed, and is stored', async (t) => {
  const page = await openClips(t);
  const text = await readFile(`${setup.models}/01_03.bvh`);
  const lines = text.toString().split('\n');
  const begin = lines.findIndex((line) => line.startsWith('Frames:'));
  const frames = lines.slice(begin + 2, begin + 602);
  const buffer = Buffer.from(
    [...lines.slice(0, begin), `Frames: ${frames.length}`, lines[begin + 1], ...frames, ''].join('\n'),
  );
  await page.setInputFiles('input[type=file]', { name: 'part.bvh', mimeType: 'text/plain', buffer });
  await page.locator('.rules input').first().waitFor();
  await page.getByRole('button', { name: 'Use these rules' }).click();
  await page.locator('.upload-item', { hasText: 'checked' }).waitFor();
  await page.locator('.upload-item').getByRole('button', { name: 'Store' }).click();
  await page.getByText('stored as').waitFor();
  const { status } = await call(setup.open, 'ClipService/GetClip', { name: 'databases/demo/clips/part' });
  assert.equal(status, 200);
});
