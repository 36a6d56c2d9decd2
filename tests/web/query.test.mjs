// The view of queries: recognition, generation probability, prediction.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { checkAccessibility, drop, newPage } from './support/browser.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, motionOf } from './support/stream.mjs';

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
  await page.locator('.path-map', { hasText: /Path: \d/ }).waitFor();
  await page.getByLabel('Layers').fill('3');
  await page.getByRole('button', { name: 'Show generation probability' }).click();
  await page.locator('figure.profile', { hasText: 'Layer 3' }).waitFor();
  await page.waitForURL(/layers=3/);
  // Who opens the shared address sees the same chart.
  await page.reload();
  await page.locator('figure.profile', { hasText: 'Layer 3' }).waitFor();
  assert.equal(await page.locator('figure.profile').count(), 1);
  await checkAccessibility(page);
});

// The answer of the server about the part of 01_01 from 1 s to 4 s, after its first second.
async function predict(frames, frameRateHz, atSeconds) {
  const { body: stored } = await call(setup.open, 'ClipService/GetClip', {
    name: 'databases/demo/clips/01_01',
  });
  const { status, body } = await call(setup.open, 'QueryService/Predict', {
    database: 'databases/demo',
    observation: {
      markers: {
        frameRateHz,
        frameCount: frames.length,
        positions: Buffer.from(Float32Array.from(frames.flat()).buffer).toString('base64'),
        legLengthM: stored.clip.legLengthM,
      },
    },
    atSeconds,
  });
  assert.equal(status, 200, JSON.stringify(body));
  return body.horizons;
}

test('ghosts are the predicted poses of the server, and the poses that followed', async (t) => {
  const part = { firstFrame: 60, frameCount: 181 };
  const { frames, names, frameRateHz } = await motionOf(
    setup.open,
    'databases/demo/clips/01_01',
    part,
  );
  const horizons = await predict(frames, frameRateHz, 1);
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/query/demo?clip=01_01&from=1&to=4&at=1&without=0`);
  const rows = page.locator('section[aria-label="Estimation and prediction"] tbody tr');
  await rows.nth(horizons.length - 1).waitFor();
  const followed = (seconds) => {
    const at = seconds * frameRateHz;
    const low = Math.min(Math.floor(at + 1e-6), frames.length - 1);
    const next = frames[Math.min(low + 1, frames.length - 1)];
    return frames[low].map((value, i) => value + (at - low) * (next[i] - value));
  };
  const predicted = horizons.map(({ markerPositions }) => floatsOf(markerPositions));
  const observed = horizons.map(({ seconds }) => followed(1 + seconds));
  await whenDrawn(page, '.scene canvas', (drawn) => {
    const figures = drawn
      .filter(({ instances }) => instances === names.length)
      .map(placesOfInstances);
    assert.equal(figures.length, 1 + 2 * horizons.length);
    const expected = [frames[60], ...predicted, ...observed];
    for (const [i, pose] of expected.entries()) {
      const nearest = Math.min(...figures.map((figure) => distance(figure, pose)));
      assert.ok(nearest < 1e-4, `pose ${i} of ${expected.length}: ${nearest} m away`);
    }
  });
  // The text has the mean distance of the markers.
  for (const [i, { expectedErrorM }] of horizons.entries()) {
    const errors = names.map((_, m) =>
      Math.hypot(
        ...[0, 1, 2].map((axis) => predicted[i][3 * m + axis] - observed[i][3 * m + axis]),
      ),
    );
    const mean = errors.reduce((sum, value) => sum + value, 0) / errors.length;
    const cells = await rows.nth(i).locator('td').allTextContents();
    assert.ok(Math.abs(Number.parseFloat(cells[1]) - 100 * mean) < 0.06, `${cells[1]}, ${mean} m`);
    if (expectedErrorM !== undefined)
      assert.equal(cells[0], `${(100 * expectedErrorM).toFixed(1)} cm`);
  }
  await page.getByRole('button', { name: 'Remove prediction' }).click();
  await whenDrawn(page, '.scene canvas', (drawn) =>
    assert.equal(drawn.filter(({ instances }) => instances === names.length).length, 1),
  );
});

test('the lines of ribbon and player follow the motion that plays', async (t) => {
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await page.goto(`${setup.open}/#/query/demo?clip=01_01&from=1&to=4&without=0`);
  await page.locator('.ribbon rect:visible').first().waitFor();
  await page.locator('.player .play').click();
  // Frames at the line of the ribbon in pictures of a second.
  const seen = await page.evaluate(async () => {
    const [slider, head] = ['.player input[type=range]', '.ribbon .playhead'].map((each) =>
      document.querySelector(each),
    );
    const frames = [];
    const begin = performance.now();
    while (performance.now() < begin + 1000 || frames.length < 10) {
      await new Promise(requestAnimationFrame);
      frames.push((head.x1.baseVal.value / 1000) * (Number(slider.max) + 1));
    }
    return frames;
  });
  const falls = seen.filter((frame, i) => i > 0 && frame < seen[i - 1]).length;
  assert.ok(falls <= 1 && new Set(seen).size >= 8, `plays, and begins again at its end: ${seen}`);
  await page.locator('.player .play').click();
  const [frame, at] = await page.evaluate(() => {
    const slider = document.querySelector('.player input[type=range]');
    const x = document.querySelector('.ribbon .playhead').x1.baseVal.value / 1000;
    return [Number(slider.value), x * (Number(slider.max) + 1)];
  });
  assert.ok(frame > 0 && Math.abs(at - frame) < 1.5, `line at ${at}, player at ${frame}`);
});

test('a dropped file is recognized as the server does', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/query/demo`);
  const file = await readFile(`${setup.models}/01_03.bvh`);
  await drop(page.locator('form.drop-zone'), '01_03.bvh', file);
  await page.locator('.ribbon rect:visible').first().waitFor();
  // The form asks about the same file again.
  const chosen = page.locator('form.drop-zone input[type=file]');
  assert.equal(await chosen.evaluate((input) => input.files[0].name), '01_03.bvh');
  await page.getByLabel('Window, s').fill('0.5');
  await page.getByRole('button', { name: 'Ask', exact: true }).click();
  await page.waitForURL(/window=0\.5/);
  await page.locator('.ribbon rect:visible').first().waitFor();
  assert.equal(await page.locator('.notice.error:visible').count(), 0);
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
  await page.goto(
    `${setup.open}/#/query/demo?clip=01_01&to=2&filter=label%20%3D%20%3D%20walk&without=0`,
  );
  const notice = page.locator('.notice.error');
  await notice.waitFor();
  assert.ok((await notice.textContent()).includes(body.message.slice(0, 20)));
});
