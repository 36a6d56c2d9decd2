// Names, labels and descriptions are shown as text in every view, never as HTML.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, settled, shown } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

async function checkHarmless(page) {
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator('img[src=x], script:not([src])').count(), 0);
}

test('hostile texts of a database in every view of the navigation', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/`);
  await shown(page);
  const links = await page
    .locator('nav a')
    .evaluateAll((anchors) => anchors.map((anchor) => anchor.getAttribute('href')));
  const own = links.filter((link) => link?.startsWith('#/'));
  for (const link of own) {
    const hostile = link.replace('/demo', '/hostile');
    await page.goto(`${setup.open}/${hostile}`);
    await shown(page);
    await settled(page);
    await checkHarmless(page);
  }
  t.diagnostic(`${own.length} views`);
});

test('hostile labels in the timeline of a clip and in the answer of a query', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/clip/hostile/01_01`);
  const segment = page.locator('.segment-body').first();
  await segment.waitFor();
  assert.ok((await segment.textContent()).includes(setup.hostile));
  await checkHarmless(page);
  await page.goto(`${setup.open}/#/query/hostile?clip=01_01&to=3&without=0`);
  await page.locator('.ribbon rect:visible').first().waitFor();
  assert.ok((await page.locator('.ribbon .legend').textContent()).includes(setup.hostile));
  await checkHarmless(page);
});

test('hostile texts in the address', async (t) => {
  const page = await newPage(t);
  for (const part of [setup.hostile, `clips/${setup.hostile}`, `clip/demo/${setup.hostile}`]) {
    const address = part.split('/').map(encodeURIComponent).join('/');
    await page.goto('about:blank');
    await page.goto(`${setup.open}/#/${address}?q=${encodeURIComponent(setup.hostile)}`);
    await shown(page);
    await settled(page);
    await checkHarmless(page);
  }
});
