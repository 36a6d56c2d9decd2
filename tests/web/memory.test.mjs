// Memory stays bounded while clips are browsed.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage, shown } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

const clips = ['01_01', '01_03', 'Boxing_Toes'];

// Opens clips one after the other, each until its motion is complete.
function browse(page, count) {
  return page.evaluate(
    async ([names, total]) => {
      const wait = () => new Promise((resolve) => setTimeout(resolve, 4));
      for (let index = 0; index < total; ++index) {
        const name = names[index % names.length];
        location.hash = `#/clip/demo/${name}`;
        const complete = () =>
          document.querySelector('h1')?.textContent === name &&
          document.querySelector('.chart canvas') &&
          document.querySelector('.segment-body');
        while (!complete()) await wait();
      }
    },
    [clips, count],
  );
}

async function measure(session) {
  await session.send('HeapProfiler.collectGarbage');
  const heap = await session.send('Runtime.getHeapUsage');
  const { nodes, jsEventListeners } = await session.send('Memory.getDOMCounters');
  const bytes = heap.usedSize + (heap.backingStorageSize ?? 0) + (heap.embedderHeapUsedSize ?? 0);
  return { mebibytes: bytes / 2 ** 20, nodes, jsEventListeners };
}

// A context of WebGL that is not released is a warning of the console after 16 of them.
test('200 clips leave nothing behind', async (t) => {
  const page = await newPage(t, { viewport: { width: 320, height: 240 } });
  await page.goto(`${setup.open}/#/clips/demo`);
  await shown(page);
  const session = await page.context().newCDPSession(page);
  await browse(page, 20);
  const before = await measure(session);
  await browse(page, 180);
  const after = await measure(session);
  t.diagnostic(`after 20 clips ${JSON.stringify(before)}, after 200 ${JSON.stringify(after)}`);
  assert.ok(after.mebibytes < before.mebibytes + 8);
  assert.ok(after.nodes < before.nodes + 500);
  assert.ok(after.jsEventListeners < before.jsEventListeners + 50);
});
