// The view of running streams.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown, until } from './support/browser.mjs';
import { bvhOf, readBvh } from './support/bvh.mjs';
import { lineValues, recordCharts } from './support/charts.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, watch } from './support/stream.mjs';
import { hide, recordVisibility, show } from './support/visibility.mjs';

// A recorded motion of 30 s, four times.
async function writeLongMotion() {
  const motion = await readBvh('Boxing_Toes');
  const path = join(setup.folder, 'long.bvh');
  await writeFile(path, bvhOf(motion, Array.from({ length: 4 }, () => motion.rows).flat()));
  return path;
}

// Sends a motion in real time, as a robot does.
function observe(t, file) {
  const stream = spawn(
    setup.motiondb,
    [
      ...['--server', setup.openAddress, 'observe', 'demo', file],
      ...['--realtime', '--horizon', '0.2,0.5'],
    ],
    { stdio: 'ignore' },
  );
  t.after(() => stream.kill());
  return stream;
}

test('the list of live streams is empty without a stream', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/live/demo`);
  await shown(page);
  await page.getByText('No stream runs').waitFor();
  await checkAccessibility(page);
});

// Reads the answers of a stream as the page does; the list that is returned grows until the test ends.
function collectAnswers(t, name) {
  const answers = [];
  const controller = new AbortController();
  t.after(() => controller.abort());
  const read = async () => {
    for await (const message of watch(
      setup.open,
      'ObserveService/WatchStream',
      { name },
      controller.signal,
    )) {
      if (!message.answer) continue;
      const horizons = message.answer.horizons ?? [];
      answers.push({
        frame: Number(message.answer.frame ?? 0),
        labels: message.answer.labels ?? [],
        unknown: message.answer.unknownProbability ?? 0,
        latencyMs: 1000 * message.latencySeconds,
        body: floatsOf(message.markerPositions),
        ghosts: horizons.map(({ markerPositions }) => floatsOf(markerPositions)),
      });
    }
  };
  read().catch(() => {}); // ends with the test
  return answers;
}

// The newest values of the chart are latencies of the server, in order.
async function checkLatencies(page, answers) {
  const [drawn] = await lineValues(page.locator('.chart canvas'));
  const newest = drawn.slice(-30);
  assert.equal(newest.length, 30);
  const tolerance = 0.02 * Math.max(...drawn);
  const known = answers.map(({ latencyMs }) => latencyMs);
  let at = known.length - 1;
  for (const value of [...newest].reverse()) {
    while (at >= 0 && Math.abs(known[at] - value) > tolerance) --at;
    assert.ok(at-- >= 0, `${newest} in ${known.slice(-60)}`);
  }
}

// The bars of the last two seconds have the probabilities of the server, and a colour for each label.
async function checkRibbon(page, answers, frameRateHz) {
  const { frame, columns, seconds } = await page.evaluate(() => {
    const title = [...document.querySelectorAll('dt')].find((dt) => dt.textContent === 'Frame');
    const picture = document.querySelector('.ribbon [role=img]');
    const canvas = picture.querySelector('canvas');
    const { width, height } = canvas;
    const pixels = new Uint32Array(
      canvas.getContext('2d').getImageData(0, 0, width, height).data.buffer,
    );
    const columns = Array.from({ length: width }, (_, x) => {
      const column = Array.from({ length: height }, (__, y) => pixels[y * width + x]);
      return {
        fraction: column.filter((pixel) => pixel !== 0).length / height,
        color: column.at(-1),
      };
    });
    const text = title.nextSibling.textContent.replaceAll(',', '');
    const seconds = Number(/last (\d+) seconds/.exec(picture.getAttribute('aria-label'))[1]);
    return { frame: Number(text), columns, seconds };
  });
  const scale = columns.length / seconds / frameRateHz; // columns a frame
  const colors = new Map();
  let checked = 0;
  let right = 0;
  for (const [i, answer] of answers.entries()) {
    const next = answers[i + 1];
    if (!next || next.frame > frame || answer.frame < frame - 2 * frameRateHz) continue;
    const [best] = answer.labels;
    const isUnknown = !best || best.probability < answer.unknown;
    const expected = Math.max(isUnknown ? answer.unknown : best.probability, 0.04);
    const middle = (answer.frame + next.frame) / 2;
    const x = Math.floor(columns.length - (frame - middle) * scale);
    const { fraction, color } = columns[Math.min(x, columns.length - 1)];
    ++checked;
    if (Math.abs(fraction - expected) > 0.03) continue;
    ++right;
    // Unknown motion is hatched.
    if (isUnknown) continue;
    const { label } = best;
    colors.set(label, [...(colors.get(label) ?? []), color]);
  }
  // A slow page leaves answers out.
  assert.ok(checked > 20 && right >= 0.7 * checked, `${right} of ${checked} bars`);
  // Columns between two bars have mixed colours.
  const ofLabels = [...colors.values()].map((all) => {
    const middle = [...all].sort((a, b) => a - b)[all.length >> 1];
    assert.ok(all.filter((each) => each === middle).length > 0.7 * all.length, `colours ${all}`);
    return middle;
  });
  assert.equal(new Set(ofLabels).size, colors.size, 'one colour for each label');
}

test('a stream shows its figure, labels, prediction and latency until it ends', async (t) => {
  const page = await newPage(t, {
    viewport: { width: 500, height: 600 },
    expected: [/willReadFrequently/], // the ribbon is read several times
  });
  await recordDrawing(page);
  await recordCharts(page);
  await page.goto(`${setup.open}/#/live/demo`);
  await shown(page);
  const stream = observe(t, await writeLongMotion());
  await page.locator('table td a').first().press('Enter');
  const facts = page.locator('section dl');
  await facts.getByText(/0\.20 s: .*0\.50 s: /).waitFor();
  await checkProgress(facts, page);
  assert.match(await facts.locator('dt:text-is("Latency") + dd').textContent(), /^\d+\.\d ms$/);
  await page.locator('.ribbon-text', { hasText: /%/ }).waitFor();
  await page.locator('.chart canvas').waitFor();

  // Figure and ghosts are those of one answer of the server.
  const { body: list } = await call(setup.open, 'ObserveService/ListStreams', {
    parent: 'databases/demo',
  });
  const answers = collectAnswers(t, list.streams[0].name);
  await whenDrawn(page, '.live-scene canvas', (drawn) => {
    const count = (answers[0]?.body.length ?? 0) / 3;
    const figures = drawn.filter(({ instances }) => instances === count).map(placesOfInstances);
    assert.equal(figures.length, 3, 'the figure and two ghosts');
    const [body] = figures;
    const answer = answers.find((each) => distance(each.body, body) < 1e-5);
    assert.ok(answer, 'an answer with this figure');
    for (const ghost of answer.ghosts) {
      const nearest = Math.min(...figures.slice(1).map((figure) => distance(figure, ghost)));
      assert.ok(nearest < 1e-5, `ghost ${nearest} m away`);
      assert.ok(distance(ghost, body) > 0.005, 'the figure moves');
    }
  });
  const [{ frameRateHz }] = list.streams;
  // Pictures and answers can be of different moments.
  await until(() => checkLatencies(page, answers), 60);
  await until(() => checkRibbon(page, answers, frameRateHz), 60);
  for (const colorScheme of ['light', 'dark']) {
    await page.emulateMedia({ colorScheme });
    await checkAccessibility(page);
  }

  stream.kill();
  await page.getByText('The stream has ended.').waitFor();
  await page.getByText('No stream runs').waitFor();
});

test('without WebGL a stream shows its labels, prediction and latency', async (t) => {
  const page = await newPage(t, { viewport: { width: 500, height: 600 }, colorScheme: 'light' });
  await disableWebGL(page);
  await recordVisibility(page);
  const stream = observe(t, `${setup.models}/Boxing_Toes.bvh`);
  await page.goto(`${setup.open}/#/live/demo`);
  await page.locator('table td a').first().press('Enter');
  await page.getByText('This browser has no WebGL').waitFor();
  const facts = page.locator('section dl');
  await facts.getByText(/0\.20 s: .*0\.50 s: /).waitFor();
  await checkProgress(facts, page);
  await page.locator('.ribbon-text', { hasText: /%/ }).waitFor();
  const colours = await page.locator('.ribbon canvas').evaluate((canvas) => {
    const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
  assert.ok(colours > 1, 'labels in the ribbon');
  await page.locator('.chart canvas').waitFor();
  await checkAccessibility(page);

  // A hidden page does not watch.
  const ended = page.waitForEvent('requestfailed', (request) =>
    request.url().endsWith('WatchStream'),
  );
  await hide(page);
  await ended;
  await show(page);
  await checkProgress(facts, page);
  stream.kill();
  await page.getByText('The stream has ended.').waitFor();
});

// Waits until the page shows later frames.
async function checkProgress(facts, page) {
  const text = await facts.locator('dt:text-is("Frame") + dd').textContent();
  await page.waitForFunction(
    (frame) => {
      const title = [...document.querySelectorAll('dt')].find((dt) => dt.textContent === 'Frame');
      return Number(title.nextSibling.textContent.replaceAll(',', '')) > frame + 20;
    },
    Number(text.replaceAll(',', '')),
  );
}

test('an unknown stream is reported', async (t) => {
  const page = await newPage(t, { expected: [/status of 404/] });
  await page.goto(`${setup.open}/#/live/demo/none`);
  await page.getByText('This stream does not run any more.').waitFor();
});
