// The view of running streams.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { test } from 'node:test';
import { checkAccessibility, newPage, shown } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

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

test('a stream shows its figure, labels, prediction and latency until it ends', async (t) => {
  const page = await newPage(t, { viewport: { width: 500, height: 600 } });
  await keepDrawings(page);
  await page.goto(`${setup.open}/#/live/demo`);
  await shown(page);
  const stream = observe(t, 'Boxing_Toes.bvh');
  await page.locator('table td a').first().press('Enter');
  const facts = page.locator('section dl');
  await facts.getByText(/0\.20 s: .*0\.50 s: /).waitFor();
  const frameOf = async () =>
    Number((await facts.locator('dt:text-is("Frame") + dd').textContent()).replaceAll(',', ''));
  const before = await frameOf();
  await page.waitForFunction(
    (frame) => {
      const title = [...document.querySelectorAll('dt')].find((dt) => dt.textContent === 'Frame');
      return Number(title.nextSibling.textContent.replaceAll(',', '')) > frame + 20;
    },
    before,
  );
  assert.match(await facts.locator('dt:text-is("Latency") + dd').textContent(), /^\d+\.\d ms$/);
  await page.locator('.ribbon-text', { hasText: /%/ }).waitFor();
  // The figure is not the empty scene.
  assert.ok((await colorsOf(page, '.live-scene canvas')) > 3);
  await page.locator('.chart canvas').waitFor();
  await checkAccessibility(page);
  stream.kill();
  await page.getByText('The stream has ended.').waitFor();
  await page.getByText('No stream runs').waitFor();
});

test('an unknown stream is reported', async (t) => {
  const page = await newPage(t, { expected: [/status of 404/] });
  await page.goto(`${setup.open}/#/live/demo/none`);
  await page.getByText('This stream does not run any more.').waitFor();
});

// Number of different colours of a canvas.
function colorsOf(page, selector) {
  return page.evaluate((css) => {
    const source = document.querySelector(css);
    const copy = document.createElement('canvas');
    [copy.width, copy.height] = [source.width, source.height];
    const context = copy.getContext('2d');
    context.drawImage(source, 0, 0);
    const { data } = context.getImageData(0, 0, copy.width, copy.height);
    return new Set(new Uint32Array(data.buffer)).size;
  }, selector);
}

// Lets a test read what WebGL has drawn.
function keepDrawings(page) {
  return page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, options) {
      return original.call(this, kind, { ...options, preserveDrawingBuffer: true });
    };
  });
}
