// Memory stays bounded while clips are browsed.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { disableWebGL, newPage, shown } from './support/browser.mjs';
import { cancelModel, kManyClips, storeManyClips } from './support/many_clips.mjs';
import { setup } from './support/setup.mjs';

const kCache = 96; // MiB of motion that the page keeps (client/web/src/shell/shell.ts)

// Opens clips one after the other, each until its motion is complete. Returns how many; fewer than
// all if the time is over before.
function browse(page, names, seconds) {
  return page.evaluate(
    async ([names, seconds]) => {
      const end = performance.now() + 1000 * seconds;
      const wait = () => new Promise((resolve) => setTimeout(resolve, 4));
      for (const [index, name] of names.entries()) {
        if (performance.now() > end) return index;
        location.hash = `#/clip/many/${name}`;
        const complete = () =>
          document.querySelector('h1')?.textContent === name &&
          document.querySelector('.chart canvas') &&
          document.querySelector('.segment-body');
        while (!complete() && performance.now() < end) await wait();
      }
      return names.length;
    },
    [names, seconds],
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
  const clips = (await storeManyClips()).slice(0, count);
  await cancelModel();
  const names = clips.map(({ name }) => name);
  await page.goto(`${setup.open}/#/clips/many`);
  await shown(page);
  const session = await page.context().newCDPSession(page);
  const begun = await browse(page, names.slice(0, warmUp), seconds);
  const before = await measure(session);
  const more = await browse(page, names.slice(begun), seconds);
  const after = await measure(session);
  const attached = await attachedNodes(page);
  t.diagnostic(
    `after ${begun} clips ${JSON.stringify(before)}, after ${more} more ${JSON.stringify(after)}, ` +
      `${attached} nodes in the document`,
  );
  assert.ok(begun > 0 && more > 0);
  const motion = (first, end) =>
    clips.slice(first, end).reduce((sum, clip) => sum + clip.mebibytes, 0);
  const [cached, loaded] = [motion(0, begun), motion(begun, begun + more)];
  const expected = before.mebibytes + Math.min(loaded, kCache - cached);
  t.diagnostic(
    `motion: ${cached.toFixed(1)} MiB, then ${loaded.toFixed(1)} MiB; expected ${expected.toFixed(1)} MiB`,
  );
  assert.ok(after.mebibytes < expected + 8);
  // The view that is open, and those that have just been closed.
  assert.ok(after.nodes < 6 * attached);
  assert.ok(after.jsEventListeners < 2 * before.jsEventListeners);
  return { opened: begun + more, loaded: cached + loaded };
}

const viewport = { width: 320, height: 240 };

// A context of WebGL that is not released is a warning of the console after 16 of them. A busy
// machine opens fewer clips. By hand, all clips: MOTIONDB_WEBGL_CLIPS=all.
test('pictures leave nothing behind', async (t) => {
  const [count, seconds] = process.env['MOTIONDB_WEBGL_CLIPS'] === 'all' ? [200, 600] : [30, 12];
  await checkMemory(t, await newPage(t, { viewport }), count / 5, count, seconds);
});

// Without WebGL, which takes most of the time.
test('200 clips leave nothing behind', async (t) => {
  const page = await newPage(t, { viewport });
  await disableWebGL(page);
  const { opened, loaded } = await checkMemory(t, page, 20, kManyClips, 120);
  assert.equal(opened, kManyClips);
  assert.ok(loaded > 1.2 * kCache, 'more motion than the page keeps');
});
