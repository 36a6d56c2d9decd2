// Zoom of the generation probability and of the recognition ribbon, and the clip of a line.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, until } from './support/browser.mjs';
import { recordCharts } from './support/charts.mjs';
import { setup } from './support/setup.mjs';
import { fingersOf } from './support/touch.mjs';

async function openQuery(t) {
  const page = await newPage(t, {
    viewport: { width: 800, height: 700 },
    deviceScaleFactor: 1,
    hasTouch: true,
  });
  await recordCharts(page);
  await page.goto(`${setup.open}/#/query/demo?clip=01_01&layers=3&without=0`);
  await page.locator('figure.profile canvas').waitFor();
  await page.locator('.ribbon rect:visible').first().waitFor();
  return page;
}

const linesOf = (page) =>
  page.locator('figure.profile canvas').evaluate((node) => window.chartOf(node).lines);

// Mean distance of the values of a line, px.
async function stepOf(page) {
  const [{ points }] = await linesOf(page);
  return (points.at(-1)[0] - points[0][0]) / (points.length - 1);
}

const waitForStep = (page, expected) =>
  until(async () => {
    const step = await stepOf(page);
    assert.ok(Math.abs(step / expected - 1) < 0.06, `${step} px, not ${expected}`);
  });

test('generation probability is zoomed by keys and fingers', async (t) => {
  const page = await openQuery(t);
  const chart = page.locator('figure.profile .chart');
  await chart.scrollIntoViewIfNeeded();
  const step = await stepOf(page);
  await chart.focus();
  await page.keyboard.press('+');
  await waitForStep(page, 1.5 * step);
  // Another theme keeps the zoom.
  await page.getByRole('button', { name: 'Dark', exact: true }).press('Enter');
  await waitForStep(page, 1.5 * step);
  await chart.focus();
  await page.keyboard.press('-');
  await waitForStep(page, step);
  const touch = await fingersOf(page);
  const plot = await chart.locator('.u-over').boundingBox();
  const pair = (half) =>
    [-half, half].map((each) => [plot.x + plot.width * (0.5 + each), plot.y + plot.height / 2]);
  await touch([0.1, 0.15, 0.2].map(pair));
  await waitForStep(page, 2 * step);
  await chart.focus();
  await page.keyboard.press('0');
  await waitForStep(page, step);
});

test('the clip of the nearest line is named, by pointer and by keys', async (t) => {
  const page = await openQuery(t);
  const chart = page.locator('figure.profile .chart');
  await chart.scrollIntoViewIfNeeded();
  const text = page.locator('figure.profile output');
  assert.match(await text.textContent(), /^Point at a line/);
  const colors = new Map(
    await page
      .locator('section[aria-label="Generation probability"] .legend-clip')
      .evaluateAll((entries) =>
        entries.map((entry) => [entry.firstElementChild.style.backgroundColor, entry.textContent]),
      ),
  );
  const rgb = (color) =>
    `rgb(${[1, 3, 5].map((at) => Number.parseInt(color.slice(at, at + 2), 16)).join(', ')})`;
  const lines = await linesOf(page);
  assert.equal(lines.length, 3); // of three labels
  const canvas = await chart.locator('canvas').boundingBox();
  const seen = new Set();
  for (const { color, points } of lines) {
    // The point that is farthest from all other lines.
    const alone = ([x, y]) =>
      Math.min(
        ...lines.flatMap((other) =>
          other.color === color
            ? []
            : other.points.filter(([at]) => at === x).map(([, height]) => Math.abs(height - y)),
        ),
      );
    const [x, y] = points.reduce((best, point) => (alone(point) > alone(best) ? point : best));
    await page.mouse.move(canvas.x + x, canvas.y + y);
    const label = colors.get(rgb(color));
    await until(async () =>
      assert.match(await text.textContent(), new RegExp(`\\(${label}\\): -?\\d+\\.\\d at \\d`)),
    );
    seen.add(await text.textContent());
  }
  assert.equal(seen.size, 3);
  // By keys, without a pointer.
  await page.mouse.move(5, 5);
  await until(async () => assert.match(await text.textContent(), /^Point at a line/));
  await chart.focus();
  const named = new Set();
  for (let i = 0; i < 3; ++i) {
    await page.keyboard.press('ArrowUp');
    named.add(await text.textContent());
  }
  assert.deepEqual([...named].map((each) => each.split(' ')[0]).sort(), [
    '01_01',
    '01_03',
    'Boxing_Toes',
  ]);
});

// The part of the motion that the ribbon shows: [begin, end], 0 to 1.
async function ribbonRange(page) {
  const text = await page.locator('.ribbon svg').getAttribute('viewBox');
  const [left, , width] = text.split(' ').map(Number);
  return [left / 1000, (left + width) / 1000];
}

async function checkRange(page, expected) {
  await until(async () => {
    const range = await ribbonRange(page);
    const away = Math.max(...range.map((value, i) => Math.abs(value - expected[i])));
    assert.ok(away < 0.02, `${range}, not ${expected}`);
  });
}

test('the ribbon is zoomed by wheel, fingers and keys, and a click finds its moment', async (t) => {
  const page = await openQuery(t);
  const ribbon = page.locator('.ribbon svg');
  await ribbon.scrollIntoViewIfNeeded();
  const box = await ribbon.boundingBox();
  const y = box.y + box.height / 2;
  await page.mouse.move(box.x + box.width / 2, y);
  await page.mouse.wheel(0, -500 * Math.log(2));
  await checkRange(page, [0.25, 0.75]);
  await page.mouse.click(box.x + 0.8 * box.width, y);
  const frameOf = async () => Number(await page.getByLabel('Frame', { exact: true }).inputValue());
  const last = Number(await page.getByLabel('Frame', { exact: true }).getAttribute('max'));
  await until(async () => assert.ok(Math.abs((await frameOf()) / last - 0.65) < 0.01));
  // The wheel zooms out, to all.
  await page.mouse.move(box.x + box.width / 2, y);
  await page.mouse.wheel(0, 500);
  await checkRange(page, [0, 1]);
  const touch = await fingersOf(page);
  const pair = (half) => [-half, half].map((each) => [box.x + box.width * (0.5 + each), y]);
  await touch([0.1, 0.15, 0.2].map(pair));
  await checkRange(page, [0.25, 0.75]);
  await ribbon.focus();
  await page.keyboard.press('0');
  await checkRange(page, [0, 1]);
  // Keys zoom about the present time; the part that is shown follows it.
  await page.keyboard.press('+');
  const begin = 0.65 - 0.65 / 1.5;
  await checkRange(page, [begin, begin + 2 / 3]);
  await page.keyboard.press('Home');
  await checkRange(page, [0, 2 / 3]);
});
