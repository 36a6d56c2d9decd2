// A page in the background keeps no connection, and catches up when it is visible again.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { disableWebGL, newPage } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { failedStream } from './support/stream.mjs';
import { hide, recordVisibility, show } from './support/visibility.mjs';

const clip = 'databases/demo/clips/01_03';
const isWatch = (request) => request.url().endsWith('DatabaseService/WatchDatabase');

async function setTitle(title) {
  const { status } = await call(setup.open, 'ClipService/UpdateClip', {
    clip: { name: clip, title },
    updateMask: 'title',
  });
  assert.equal(status, 200);
}

test('hidden pages of clips and of a clip hold no stream, and show what has changed', async (t) => {
  const page = await newPage(t, { expected: [/status of 404/] });
  await disableWebGL(page); // takes most of the time
  await recordVisibility(page);
  let watches = 0;
  page.on('request', (request) => (watches += isWatch(request) ? 1 : 0));
  for (const [place, opened, text] of [
    [
      'clips/demo',
      page.getByRole('link', { name: '01_03' }),
      (title) => page.locator('td', { hasText: title }),
    ],
    ['clip/demo/01_03', page.locator('summary'), (title) => page.locator('dd', { hasText: title })],
  ]) {
    const watched = page.waitForRequest(isWatch);
    await page.goto(`${setup.open}/#/${place}`);
    await watched;
    await opened.click({ trial: place === 'clips/demo' });
    const ended = page.waitForEvent('requestfailed', isWatch);
    await hide(page);
    await ended;
    const before = watches;
    const title = `Changed behind ${place}`;
    await setTitle(title);
    assert.equal(await text(title).count(), 0);
    assert.equal(watches, before, 'no stream of a hidden page');
    await show(page);
    await text(title).waitFor();
    assert.equal(watches, before + 1);
  }

  // The server has forgotten some changes of the hidden time: the page reads the clip again.
  await hide(page);
  const deleted = (route) =>
    route.fulfill({ status: 404, json: { code: 'not_found', message: 'no clip' } });
  const tooOld = (route) => route.fulfill(failedStream('out_of_range', 'revision too old'));
  await page.route('**/motiondb.v1.ClipService/GetClip', deleted, { times: 1 });
  await page.route('**/motiondb.v1.DatabaseService/WatchDatabase', tooOld, { times: 1 });
  await show(page);
  await page.getByText('Another client has deleted this clip.').waitFor();
});
