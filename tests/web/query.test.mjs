// The view of queries: recognition, generation probability, prediction.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

test('a part of a clip is recognized, and the prediction compared with what happened', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/query/demo?clip=01_01&from=1&to=4&at=1&without=0`);
  await page.locator('.ribbon rect:visible').first().waitFor();
  await page.getByText('Recognized parts as a list').click();
  assert.match(await page.locator('.ribbon-runs li').first().textContent(), /\d s to .*\d %/);
  const rows = page.locator('section[aria-label="Estimation and prediction"] tbody tr');
  await rows.nth(5).waitFor();
  for (const row of await rows.all()) {
    assert.match(await row.locator('td').nth(1).textContent(), /^\d+\.\d cm$/);
  }
  await page.locator('.path-map', { hasText: /Path \(yellow\): \d/ }).waitFor();
  await page.getByLabel('Layers').fill('3');
  await page.getByRole('button', { name: 'Show generation probability' }).click();
  await page.locator('figure.profile', { hasText: 'Layer 3' }).waitFor();
  assert.match(page.url(), /layers=3/);
  await checkAccessibility(page);
});

test('a dropped file is recognized as the server does', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/query/demo`);
  await page.locator('input[type=file]').setInputFiles(`${setup.models}/01_03.bvh`);
  await page.getByRole('button', { name: 'Ask' }).click();
  await page.locator('.ribbon rect:visible').first().waitFor();
  assert.match(await page.locator('.ribbon-now').textContent(), /climb|boxing|jump|unknown/);
});

test('an error of a filter appears at the query', async (t) => {
  const { status, body } = await call(setup.open, 'ClipService/ListClips', {
    parent: 'databases/demo',
    filter: 'label = = walk',
  });
  assert.equal(status, 400);
  const page = await newPage(t, { expected: [/status of 400/] });
  await page.goto(`${setup.open}/#/query/demo?clip=01_01&to=2&filter=label%20%3D%20%3D%20walk&without=0`);
  const notice = page.locator('.notice.error');
  await notice.waitFor();
  assert.ok((await notice.textContent()).includes(body.message.slice(0, 20)));
});
