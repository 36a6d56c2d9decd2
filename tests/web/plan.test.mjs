// The view of plans: goal and obstacles on the floor, alternatives, files.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage } from './support/browser.mjs';
import { setup } from './support/setup.mjs';
import { fingersOf } from './support/touch.mjs';

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
  await page.waitForURL(/goal=/);

  await page.getByRole('button', { name: /^Disc/ }).click();
  const disc = await at(0.8, 0.2);
  await page.mouse.move(disc.x, disc.y);
  await page.mouse.down();
  await page.mouse.move(disc.x + 20, disc.y, { steps: 3 });
  await page.mouse.up();
  await page.waitForURL(/obstacles=d/);
  await floor.press('ArrowUp');

  // The start moves back and turns to the right.
  const start = floor.locator('.start circle');
  const place = async () => ({
    x: Number(await start.getAttribute('cx')),
    y: Number(await start.getAttribute('cy')),
  });
  const origin = await place();
  for (const key of ['s', 'ArrowDown', 'ArrowDown', ']']) await floor.press(key);
  await page.waitForURL(/start=-0\.2%2C0%2C-0\.175/);
  assert.ok((await place()).y > origin.y + 5);

  await page.getByRole('button', { name: 'Plan', exact: true }).click();
  await page.locator('section[aria-label="Planned motions"] tbody tr').first().waitFor();
  const first = floor.locator('.path.chosen .place').first();
  await first.waitFor();
  // The path begins at the start.
  const begin = await place();
  assert.ok(Math.abs(Number(await first.getAttribute('cx')) - begin.x) < 3);
  assert.ok(Math.abs(Number(await first.getAttribute('cy')) - begin.y) < 3);
  await page.getByRole('button', { name: 'Alternative 1' }).click();
  await page.waitForURL(/motion=1/);
  await page.reload();
  await page.locator('tbody button[aria-pressed=true]', { hasText: 'Alternative 1' }).waitFor();
  await checkAccessibility(page);

  // The first plan has no skeleton, so it has no BVH file. The page must wait for the second one,
  // also if that takes longer than a click.
  await page.route('**/motiondb.v1.QueryService/Plan', async (route) => {
    await new Promise((resolve) => setTimeout(resolve, 500));
    await route.continue();
  });
  await page.getByLabel('Start: clip').fill('01_01');
  await page.getByRole('button', { name: 'Plan', exact: true }).click();
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', { name: 'Download BVH' }).click(),
  ]);
  assert.match(download.suggestedFilename(), /\.bvh$/);

  // A search that finds nothing leaves no motion of the one before. The answer is an empty message.
  await page.route('**/motiondb.v1.QueryService/Plan', (route) =>
    route.fulfill({ status: 200, contentType: 'application/proto', body: Buffer.alloc(0) }),
  );
  const hint = page.getByText('The planned motion appears here.');
  assert.equal(await hint.count(), 0);
  await page.getByRole('button', { name: 'Plan', exact: true }).click();
  await hint.waitFor();
  assert.equal(await floor.locator('.path').count(), 0);
  assert.ok(await page.getByRole('button', { name: 'Download BVH' }).isDisabled());
});

test('the start is placed and turned by the pointer', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/plan/demo`);
  const floor = page.locator('svg.floor');
  await floor.locator('.goal circle').waitFor();
  const goal = await page.getByLabel('Goal: ahead, m').inputValue();
  const startOf = async () => {
    const [, text] = decodeURIComponent(page.url()).match(/start=([^&]+)/);
    return text.split(',').map(Number);
  };
  await page.getByRole('button', { name: /^Start:/ }).click();
  const box = await floor.boundingBox();
  const drag = async (from, to) => {
    await page.mouse.move(box.x + from[0], box.y + from[1]);
    await page.mouse.down();
    await page.mouse.move(box.x + to[0], box.y + to[1], { steps: 4 });
    await page.mouse.up();
    const circle = floor.locator('.start circle');
    for (const [i, name] of ['cx', 'cy'].entries())
      assert.ok(Math.abs(Number(await circle.getAttribute(name)) - from[i]) < 1, name);
  };
  await drag([150, 200], [90, 200]);
  await page.waitForURL(/start=/);
  // x is up, y and a positive heading are to the left.
  const first = await startOf();
  assert.ok(Math.abs(first[2] - Math.PI / 2) < 0.01, `heading ${first[2]}`);
  await drag([250, 100], [250, 160]);
  await page.waitForFunction((text) => !location.href.includes(text), `${first[0]}`);
  const second = await startOf();
  assert.ok(Math.abs(Math.abs(second[2]) - Math.PI) < 0.01, `heading ${second[2]}`);
  const [ahead, left] = [second[0] - first[0], first[1] - second[1]];
  assert.ok(
    ahead > 0.1 && Math.abs(ahead - left) < 0.03,
    `${ahead} m ahead, ${left} m to the right`,
  );
  assert.equal(await page.getByLabel('Goal: ahead, m').inputValue(), goal);
});

test('two fingers zoom and move the floor, one finger places the goal', async (t) => {
  const page = await newPage(t, { hasTouch: true });
  await page.goto(`${setup.open}/#/plan/demo`);
  const floor = page.locator('svg.floor');
  const [goal, start] = ['.goal circle', '.start circle'].map((css) => floor.locator(css));
  await goal.waitFor();
  const touch = await fingersOf(page);
  await floor.scrollIntoViewIfNeeded();
  const box = await floor.boundingBox();
  const placeOf = async (circle) =>
    Promise.all(['cx', 'cy'].map(async (name) => Number(await circle.getAttribute(name))));
  const apart = async () => {
    const [a, b] = [await placeOf(goal), await placeOf(start)];
    return Math.hypot(a[0] - b[0], a[1] - b[1]);
  };
  const values = () =>
    Promise.all(
      ['Goal: ahead, m', 'heading, degrees'].map((label) => page.getByLabel(label).inputValue()),
    );
  const [before, chosen, [x, y]] = [await apart(), await values(), await placeOf(start)];
  // What is between the fingers stays there: the start.
  const pair = (half, right = 0) =>
    [-half, half].map((each) => [box.x + x + each + right, box.y + y]);
  await touch([pair(40), pair(60), pair(80)]);
  assert.ok(Math.abs((await apart()) / before - 2) < 0.05, `${await apart()} px, ${before} px`);
  const near = await placeOf(start);
  assert.ok(Math.hypot(near[0] - x, near[1] - y) < 3, `start at ${near}, not ${[x, y]}`);
  await touch([pair(50), pair(50, 20), pair(50, 40)]);
  const moved = await placeOf(start);
  assert.ok(Math.abs(moved[0] - near[0] - 40) < 4, `start at ${moved}, was at ${near}`);
  assert.deepEqual(await values(), chosen);
  await touch([[[box.x + 60, box.y + 80]], [[box.x + 60, box.y + 40]]]);
  const placed = await placeOf(goal);
  assert.ok(Math.hypot(placed[0] - 60, placed[1] - 80) < 1, `goal at ${placed}`);
});

test('pointers draw one obstacle at a time', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/plan/demo`);
  const floor = page.locator('svg.floor');
  await floor.locator('.goal circle').waitFor();
  const discs = floor.locator('circle.obstacle:not(.draft)');
  await page.getByRole('button', { name: /^Disc/ }).click();
  await floor.dblclick({ position: { x: 60, y: 60 } });
  assert.equal(await discs.count(), 1);
  await floor.dblclick({ position: { x: 160, y: 60 } });
  assert.equal(await discs.count(), 2);

  // A second finger changes nothing, and a cancelled drag is no obstacle and does not go on.
  const send = (type, pointerId, left, top) =>
    floor.evaluate(
      (node, [kind, id, x, y]) => {
        node.setPointerCapture = () => {}; // the browser knows no such pointer
        const box = node.getBoundingClientRect();
        const at = { clientX: box.left + x, clientY: box.top + y };
        const init = { pointerId: id, isPrimary: id === 1, pointerType: 'touch', bubbles: true };
        node.dispatchEvent(new PointerEvent(kind, { ...init, ...at }));
      },
      [type, pointerId, left, top],
    );
  await send('pointerdown', 1, 100, 100);
  await send('pointerdown', 2, 250, 100);
  await send('pointermove', 2, 300, 100);
  await send('pointerup', 2, 300, 100);
  assert.equal(await discs.count(), 2);
  const draft = floor.locator('.draft');
  assert.ok(Math.abs(Number(await draft.getAttribute('cx')) - 100) < 1);
  await send('pointercancel', 1, 100, 100);
  assert.equal(await draft.count(), 0);
  await send('pointermove', 1, 200, 100);
  assert.equal(await draft.count(), 0);

  const scale = async () => Number(await discs.first().getAttribute('r'));
  const before = await scale();
  await page.getByRole('button', { name: 'Zoom in' }).click();
  assert.ok((await scale()) > 1.1 * before);
  await page.getByRole('button', { name: 'Zoom out' }).click();
  assert.ok(Math.abs((await scale()) - before) < 0.01);
});

test('obstacles are drawn with the keyboard alone', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/plan/demo`);
  const floor = page.locator('svg.floor');
  await floor.locator('.goal circle').waitFor();
  await floor.focus();
  const press = async (...keys) => {
    for (const key of keys) await page.keyboard.press(key);
  };
  const kinds = () =>
    floor.locator('.obstacle:not(.draft)').evaluateAll((all) => all.map((node) => node.tagName));

  // A disc, smaller than the first size, next to the goal.
  const spoken = page.locator('[aria-live=polite]').first();
  await press('d');
  await floor.locator('.cursor').waitFor();
  assert.match(await spoken.textContent(), /m ahead/);
  await press('ArrowUp', 'ArrowUp', 'ArrowLeft');
  const radius = async () => Number(await floor.locator('.draft').getAttribute('r'));
  const first = await radius();
  await press('[');
  assert.ok((await radius()) < first);
  assert.match(await spoken.textContent(), /Disc, radius 0\.25 m/);
  assert.deepEqual(await kinds(), []);
  await press('Enter');
  assert.deepEqual(await kinds(), ['circle']);

  // A polygon; two corners are not enough.
  await press('p', 'ArrowDown', 'Space', 'ArrowDown', 'ArrowDown', 'Space', 'Enter');
  const error = page.getByText('Expected at least 3 corners of an obstacle.');
  await error.waitFor();
  // The last corner is removed first.
  await press('Delete');
  assert.match(await spoken.textContent(), /1 corners/);
  assert.deepEqual(await kinds(), ['circle']);
  await press('Space', 'Enter');
  await error.waitFor();
  await press('ArrowRight', 'ArrowRight', 'Space', 'Enter');
  assert.deepEqual(await kinds(), ['circle', 'polygon']);
  await error.waitFor({ state: 'detached' });
  await page.waitForURL(/obstacles=d.*p/);
  // Nothing is drawn: Enter announces nothing.
  await press('ArrowUp');
  const before = await spoken.textContent();
  await press('Enter');
  assert.equal(await spoken.textContent(), before);

  // The disc is chosen and removed.
  await press('c', 'ArrowUp', 'ArrowUp', 'ArrowLeft', 'Space');
  await floor.locator('circle.obstacle.chosen').waitFor();
  assert.match(await spoken.textContent(), /Disc, radius 0\.25 m/);
  await press('Delete');
  assert.deepEqual(await kinds(), ['polygon']);

  // The goal still moves.
  await press('g');
  const goal = await page.getByLabel('Goal: ahead, m').inputValue();
  await press('ArrowUp');
  const after = await page.getByLabel('Goal: ahead, m').inputValue();
  assert.ok(Math.abs(Number(after) - Number(goal) - 0.1) < 0.011);
  assert.match(await spoken.textContent(), /^Goal .* heading/);
});
