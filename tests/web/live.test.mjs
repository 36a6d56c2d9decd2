// The view of running streams.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown } from './support/browser.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf, watch } from './support/stream.mjs';
import { hide, recordVisibility, show } from './support/visibility.mjs';

// Sends a motion in real time, as a robot does.
function observe(t, file) {
  const stream = spawn(
    setup.motiondb,
    [
      ...['--server', setup.openAddress, 'observe', 'demo', `${setup.models}/${file}`],
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
    for await (const message of watch(setup.open, 'ObserveService/WatchStream', { name }, controller.signal)) {
      if (!message.answer) continue;
      const horizons = message.answer.horizons ?? [];
      answers.push({
        body: floatsOf(message.markerPositions),
        ghosts: horizons.map(({ markerPositions }) => floatsOf(markerPositions)),
      });
    }
  };
  read().catch(() => {}); // ends with the test
  return answers;
}

test('a stream shows its figure, labels, prediction and latency until it ends', async (t) => {
  const page = await newPage(t, { viewport: { width: 500, height: 600 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/live/demo`);
  await shown(page);
  const stream = observe(t, 'Boxing_Toes.bvh');
  await page.locator('table td a').first().press('Enter');
  const facts = page.locator('section dl');
  await facts.getByText(/0\.20 s: .*0\.50 s: /).waitFor();
  await checkProgress(facts, page);
  assert.match(await facts.locator('dt:text-is("Latency") + dd').textContent(), /^\d+\.\d ms$/);
  await page.locator('.ribbon-text', { hasText: /%/ }).waitFor();
  await page.locator('.chart canvas').waitFor();

  // Figure and ghosts are those of one answer of the server.
  const { body: list } = await call(setup.open, 'ObserveService/ListStreams', { parent: 'databases/demo' });
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
  const stream = observe(t, 'Boxing_Toes.bvh');
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
  const ended = page.waitForEvent('requestfailed', (request) => request.url().endsWith('WatchStream'));
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
