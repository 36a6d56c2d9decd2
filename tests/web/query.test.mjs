// The view of queries: recognition, generation probability, prediction.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
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
  // Who opens the shared address sees the same chart.
  await page.reload();
  await page.locator('figure.profile', { hasText: 'Layer 3' }).waitFor();
  assert.equal(await page.locator('figure.profile').count(), 1);
  await checkAccessibility(page);
});

test('a dropped file is recognized as the server does', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/query/demo`);
  const bytes = (await readFile(`${setup.models}/01_03.bvh`)).toString('base64');
  const transfer = await page.evaluateHandle((text) => {
    const transfer = new DataTransfer();
    const data = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    transfer.items.add(new File([data], '01_03.bvh'));
    return transfer;
  }, bytes);
  await page.locator('form.drop-zone').dispatchEvent('drop', { dataTransfer: transfer });
  await page.locator('.ribbon rect:visible').first().waitFor();
  // The stored clip of this file has the label climb.
  await page.getByText('Recognized parts as a list').click();
  const parts = await page.locator('.ribbon-runs li').allTextContents();
  assert.ok(
    parts.some((part) => part.includes('climb')),
    parts.join('; '),
  );
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
