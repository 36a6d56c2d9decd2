// The view of plans: goal and obstacles on the floor, alternatives, files.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

test('goal and obstacles are placed on the floor, and the motion is planned', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/plan/demo`);
  const floor = page.locator('svg.floor');
  const goal = floor.locator('.goal circle');
  await goal.waitFor();
  const at = async (x, y) => {
    const box = await floor.boundingBox();
    return { x: box.x + x * box.width, y: box.y + y * box.height };
  };
  const from = await at(0.4, 0.3);
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x, from.y - 60, { steps: 4 });
  await page.mouse.up();
  assert.equal(await page.getByLabel('heading, degrees').inputValue(), '0');
  const box = await floor.boundingBox();
  assert.ok(Math.abs(Number(await goal.getAttribute('cx')) - (from.x - box.x)) < 1);
  assert.ok(Math.abs(Number(await goal.getAttribute('cy')) - (from.y - box.y)) < 1);
  assert.match(page.url(), /goal=/);

  await page.getByRole('button', { name: /^Disc/ }).click();
  const disc = await at(0.8, 0.2);
  await page.mouse.move(disc.x, disc.y);
  await page.mouse.down();
  await page.mouse.move(disc.x + 20, disc.y, { steps: 3 });
  await page.mouse.up();
  await page.waitForURL(/obstacles=d/);
  await floor.press('ArrowUp');

  await page.getByRole('button', { name: 'Plan', exact: true }).click();
  await page.locator('section[aria-label="Planned motions"] tbody tr').first().waitFor();
  await floor.locator('.path.chosen .place').first().waitFor();
  await checkAccessibility(page);
  await page.getByLabel('Start: clip').fill('01_01');
  await page.getByRole('button', { name: 'Plan', exact: true }).click();
  await page.locator('.hint', { hasText: 'Stored motion' }).waitFor();
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Download BVH' }).click(),
  ]);
  assert.match(download.suggestedFilename(), /\.bvh$/);
});
