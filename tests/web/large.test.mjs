// The map of a large database, end to end. Only with MOTIONDB_LARGE_STORE (web_page_test.py).
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { newPage } from './support/browser.mjs';
import { isBusy } from './support/busy.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const kSteps = 40; // of a zoom or a turn

// Size and time of an answer of ReadStateMap, as the page asks for it.
async function readMap(database) {
  const request = JSON.stringify({ parent: `${database}/models/current`, maxPoints: 20_000 });
  const head = Buffer.alloc(5);
  head.writeUInt32BE(request.length, 1);
  const began = performance.now();
  const response = await fetch(`${setup.large.web}/motiondb.v1.ViewService/ReadStateMap`, {
    method: 'POST',
    headers: { 'content-type': 'application/connect+json' },
    body: Buffer.concat([head, Buffer.from(request)]),
  });
  const bytes = (await response.arrayBuffer()).byteLength;
  return { bytes, milliseconds: performance.now() - began };
}

async function megabytesOf(pid, field) {
  const status = await readFile(`/proc/${pid}/status`, 'utf8');
  return (Number(status.match(new RegExp(`${field}:\\s+(\\d+)`))[1]) * 1024) / 1e6;
}

// Processor time of the server; its threads have 100 ticks a second.
async function serverSeconds() {
  const stat = await readFile(`/proc/${setup.large.pid}/stat`, 'utf8');
  const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
  return (Number(fields[11]) + Number(fields[12])) / 100;
}

// Memory of the process that runs the page: objects, arrays and code.
async function pageMegabytes(page) {
  const session = await page.context().browser().newBrowserCDPSession();
  const { processInfo } = await session.send('SystemInfo.getProcessInfo');
  const renderers = processInfo.filter(({ type }) => type === 'renderer');
  return Math.max(...(await Promise.all(renderers.map(({ id }) => megabytesOf(id, 'VmRSS')))));
}

// Counts calls that draw, and pictures of the screen that have any.
function countDrawing() {
  window.drawn = { calls: 0, pictures: 0, most: 0 };
  let inPicture = 0;
  const names = ['drawArrays', 'drawElements', 'drawArraysInstanced', 'drawElementsInstanced'];
  for (const name of names) {
    const original = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...parameters) {
      if (inPicture++ === 0) {
        queueMicrotask(() => {
          ++window.drawn.pictures;
          window.drawn.most = Math.max(window.drawn.most, inPicture);
          inPicture = 0;
        });
      }
      ++window.drawn.calls;
      return original.apply(this, parameters);
    };
  }
}

test('the map of a large database is shown, turned, zoomed and pointed at', async (t) => {
  if (setup.large === null) return t.skip('MOTIONDB_LARGE_STORE is not set');
  const { body } = await call(setup.large.web, 'DatabaseService/ListDatabases', {});
  const database = body.databases[0].name;
  const busy = isBusy() ? ' (busy machine)' : '';
  const before = await megabytesOf(setup.large.pid, 'VmRSS');
  const worked = await serverSeconds();
  const first = await readMap(database);
  const between = await serverSeconds();
  const next = await readMap(database);
  const work = [between - worked, (await serverSeconds()) - between].map((s) => s.toFixed(2));
  t.diagnostic(
    `server: first answer ${first.milliseconds.toFixed(0)} ms (processor ${work[0]} s), ` +
      `next ${next.milliseconds.toFixed(0)} ms (${work[1]} s), ` +
      `${(next.bytes / 1e6).toFixed(1)} MB of JSON${busy}`,
  );
  const page = await newPage(t, { viewport: { width: 800, height: 600 }, deviceScaleFactor: 1 });
  await page.addInitScript(countDrawing);
  const session = await page.context().newCDPSession(page);
  await session.send('Performance.enable', { timeDomain: 'threadTicks' });
  const metric = async (wanted) => {
    const { metrics } = await session.send('Performance.getMetrics');
    return metrics.find(({ name }) => name === wanted).value;
  };
  const received = [];
  await session.send('Network.enable');
  session.on('Network.loadingFinished', (event) => received.push(event.encodedDataLength));

  const began = performance.now();
  await page.goto(`${setup.large.web}/#/database/${database.split('/')[1]}`);
  await page.locator('.map-controls output', { hasText: 'Layer' }).waitFor();
  await page.waitForFunction(() => window.drawn.most > 2);
  const shown = performance.now() - began;
  const script = 1000 * (await metric('TaskDuration'));
  t.diagnostic(
    `page: first picture after ${shown.toFixed(0)} ms, ${script.toFixed(0)} ms of main thread, ` +
      `${(Math.max(...received) / 1e6).toFixed(1)} MB received${busy}`,
  );

  const canvas = page.locator('.map canvas');
  const box = await canvas.boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  const measure = async (name, step) => {
    await page.evaluate(() => Object.assign(window.drawn, { calls: 0, pictures: 0, most: 0 }));
    const [work, start] = [await metric('TaskDuration'), performance.now()];
    for (let i = 0; i < kSteps; ++i) await step(i);
    const each = (performance.now() - start) / kSteps;
    const main = (1000 * ((await metric('TaskDuration')) - work)) / kSteps;
    const { most, pictures } = await page.evaluate(() => window.drawn);
    t.diagnostic(
      `${name}: ${each.toFixed(0)} ms a step, ${main.toFixed(1)} ms of it main thread, ` +
        `${pictures} pictures, at most ${most} draw calls${busy}`,
    );
    assert.ok(most <= 100, `${most} draw calls`);
    return { each, main };
  };
  await page.mouse.move(...middle);
  const zoom = await measure('zoom', (i) => page.mouse.wheel(0, i % 20 < 10 ? -60 : 60));
  await page.mouse.down({ button: 'right' });
  const pan = await measure('pan', (i) => page.mouse.move(middle[0] + 3 * i, middle[1] + i));
  await page.mouse.up({ button: 'right' });
  const point = await measure('point', (i) => page.mouse.move(middle[0] + 2 * i, middle[1]));
  await page.locator('.node-panel', { hasText: /Node \d+ of layer/ }).waitFor();

  await session.send('HeapProfiler.collectGarbage');
  const heap = await pageMegabytes(page);
  const resident = await megabytesOf(setup.large.pid, 'VmRSS');
  const peak = await megabytesOf(setup.large.pid, 'VmHWM');
  t.diagnostic(
    `memory: page ${heap.toFixed(0)} MB; server ${before.toFixed(0)} MB before, ` +
      `${resident.toFixed(0)} MB after, at most ${peak.toFixed(0)} MB`,
  );
  assert.ok(heap < 500, `${heap} MB`);
  if (busy !== '') return;
  assert.ok(shown < 5000, `first picture after ${shown} ms`);
  for (const { each } of [zoom, pan, point]) assert.ok(each < 200, `${each} ms a step`);
});
