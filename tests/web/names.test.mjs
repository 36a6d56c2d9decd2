// Names, labels and descriptions are shown as text in every view, never as HTML.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { test } from 'node:test';
import { newPage, settled, shown } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { setup } from './support/setup.mjs';
import { markersAt } from './support/stream.mjs';

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

// Fails unless the elements have all these texts.
async function checkTexts(locator, ...texts) {
  const all = await locator.allTextContents();
  for (const text of texts) assert.ok(all.includes(text), `${text} in ${all.join('; ')}`);
}

test('hostile texts of a clip and in the answer of a query', async (t) => {
  const frame = 60;
  const markers = await markersAt(setup.open, 'databases/hostile/clips/01_01', frame);
  const [, ...place] = markers.find(([name]) => name === setup.hostileMarker);
  const eye = place.map((value, axis) => value + [1, -1, 0.2][axis]);
  const page = await newPage(t, { expected: [/status of 400/] });
  const camera = [...eye, ...place].map((value) => value.toFixed(2));
  await page.goto(`${setup.open}/#/clip/hostile/01_01?t=1.0001&show=markers&camera=${camera}`);
  const segment = page.locator('.segment-body').first();
  await segment.waitFor();
  assert.ok((await segment.textContent()).includes(setup.hostile));
  await page.locator('.chart canvas').waitFor();
  await checkTexts(page.locator('option'), setup.hostileMarker, `${setup.hostileMarker} (joint)`);
  const ofClip = ['S', 'T', 'D', 'F'].map((letter) => letter + setup.hostile);
  await checkTexts(page.locator('dd'), setup.hostile, ...ofClip);
  const box = await page.locator('.scene canvas').boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  const tip = await page.locator('.scene .overlay').textContent();
  assert.ok(tip.startsWith(`${setup.hostileMarker} `), tip);
  await segment.press('Enter');
  await page.locator('.segment-form .hint', { hasText: setup.hostile }).waitFor();
  // The server refuses such a tag; its error has the tag.
  await page.getByText('Properties', { exact: true }).click();
  await page.getByRole('button', { name: 'Edit', exact: true }).press('Enter');
  await page.getByLabel('Tags').fill(setup.hostileMarker);
  await page.getByLabel('Tags').press('Enter');
  await page.locator('.notice.error', { hasText: setup.hostileMarker }).waitFor();
  await checkHarmless(page);
  await page.goto(`${setup.open}/#/query/hostile?clip=01_01&to=3&without=0`);
  await page.locator('.ribbon rect:visible').first().waitFor();
  assert.ok((await page.locator('.ribbon .legend').textContent()).includes(setup.hostile));
  await checkHarmless(page);
  await page.goto(`${setup.open}/#/clips/hostile`);
  await page.locator('table.clips tbody tr').waitFor();
  await checkTexts(page.locator('table.clips td'), setup.hostile, ...ofClip.slice(0, 2));
  await page.locator('.facet', { hasText: ofClip[0] }).waitFor();
  const motion = await readBvh('01_01', join(setup.folder, 'hostile'));
  const buffer = Buffer.from(bvhOf(motion, motion.rows.slice(600, 900)));
  await page.setInputFiles('input[type=file]', {
    name: 'part.bvh',
    mimeType: 'text/plain',
    buffer,
  });
  await page.locator('.rules th', { hasText: setup.hostileMarker }).waitFor();
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
