// Memory stays bounded while clips are browsed.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { disableWebGL, newPage, shown } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

const clips = ['01_01', '01_03', 'Boxing_Toes'];

// Opens clips one after the other, each until its motion is complete. Returns how many; fewer than
// `count` if the time is over before.
function browse(page, count, seconds) {
  return page.evaluate(
    async ([names, total, seconds]) => {
      const end = performance.now() + 1000 * seconds;
      const wait = () => new Promise((resolve) => setTimeout(resolve, 4));
      for (let index = 0; index < total; ++index) {
        const name = names[index % names.length];
        if (performance.now() > end) return index;
        location.hash = `#/clip/demo/${name}`;
        const complete = () =>
          document.querySelector('h1')?.textContent === name &&
          document.querySelector('.chart canvas') &&
          document.querySelector('.segment-body');
        while (!complete() && performance.now() < end) await wait();
      }
      return total;
    },
    [clips, count, seconds],
  );
}

// Nodes of the document, which are those of the view that is open.
const attachedNodes = (page) =>
  page.evaluate(() => {
    const walker = document.createTreeWalker(document);
    let count = 1;
    while (walker.nextNode()) ++count;
    return count;
  });

async function measure(session) {
  // Objects of the page and of the DOM refer to each other: one collection does not free them.
  for (let i = 0; i < 4; ++i) await session.send('HeapProfiler.collectGarbage');
  const heap = await session.send('Runtime.getHeapUsage');
  const { nodes, jsEventListeners } = await session.send('Memory.getDOMCounters');
  const bytes = heap.usedSize + (heap.backingStorageSize ?? 0) + (heap.embedderHeapUsedSize ?? 0);
  return { mebibytes: bytes / 2 ** 20, nodes, jsEventListeners };
}

// Returns how many clips were opened.
async function checkMemory(t, page, warmUp, count, seconds) {
  await page.goto(`${setup.open}/#/clips/demo`);
  await shown(page);
  const session = await page.context().newCDPSession(page);
  const begun = await browse(page, warmUp, seconds);
  const before = await measure(session);
  const more = await browse(page, count - begun, seconds);
  const after = await measure(session);
  const attached = await attachedNodes(page);
  t.diagnostic(
    `after ${begun} clips ${JSON.stringify(before)}, after ${more} more ${JSON.stringify(after)}, ` +
      `${attached} nodes in the document`,
  );
  assert.ok(begun > 0 && more > 0);
  assert.ok(after.mebibytes < before.mebibytes + 8);
  // The view that is open, and those that have just been closed.
  assert.ok(after.nodes < 6 * attached);
  assert.ok(after.jsEventListeners < 2 * before.jsEventListeners);
  return begun + more;
}

const viewport = { width: 320, height: 240 };

// A context of WebGL that is not released is a warning of the console after 16 of them. A busy
// machine opens fewer clips.
test('pictures leave nothing behind', async (t) => {
  await checkMemory(t, await newPage(t, { viewport }), 6, 30, 12);
});

// Without WebGL, which takes most of the time.
test('200 clips leave nothing behind', async (t) => {
  const page = await newPage(t, { viewport });
  await disableWebGL(page);
  assert.equal(await checkMemory(t, page, 20, 200, 120), 200);
});
