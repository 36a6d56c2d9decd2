// Calls of the page are in the metrics of the server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { disableWebGL, newPage, settled, until } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

// The values of a metric by the text of its labels; '' without labels.
async function metric(name) {
  const text = await (await fetch(`${setup.openMetrics}/metrics`)).text();
  const lines = text
    .split('\n')
    .filter((line) => line.startsWith(`${name}{`) || line.startsWith(`${name} `));
  return new Map(
    lines.map((line) => {
      const [, labels = '', value] = line.match(/^\w+(?:{(.*)})? (.*)$/);
      return [labels, Number(value)];
    }),
  );
}

// The ended calls since `before`, such as 'ClipService.ListClips OK'.
async function callsSince(before) {
  const calls = {};
  for (const [labels, value] of await metric('motiondb_requests_total')) {
    const added = value - (before.get(labels) ?? 0);
    const [, method] = labels.match(/method="(.*?)"/);
    const [, code] = labels.match(/code="(.*?)"/);
    if (added > 0) calls[`${method} ${code}`] = added;
  }
  return calls;
}

test('the metrics count the calls of the page, their codes and its streams', async (t) => {
  const openStreams = async () => (await metric('motiondb_open_streams')).get('');
  await until(async () => assert.equal(await openStreams(), 0), 30); // those of earlier tests
  const before = await metric('motiondb_requests_total');
  const durations = async () =>
    (await metric('motiondb_request_seconds_count')).get('method="ClipService.ListClips"');
  const timed = (await durations()) ?? 0;
  const page = await newPage(t);
  await disableWebGL(page);
  const expected = {};
  const add = (name) => (expected[name] = (expected[name] ?? 0) + 1);
  const methodOf = (request) =>
    request
      .url()
      .match(/motiondb\.v1\.(\w+\/\w+)/)?.[1]
      .replace('/', '.');
  const running = new Set(); // calls that end by themselves
  page.on('request', (request) => {
    const method = methodOf(request);
    if (method && method !== 'DatabaseService.WatchDatabase') running.add(request);
  });
  page.on('requestfinished', (request) => {
    if (running.delete(request)) add(`${methodOf(request)} OK`);
  });
  await page.goto(`${setup.open}/#/clips/demo`);
  await page.locator('main tbody tr').nth(2).waitFor();
  await settled(page);
  await until(() => assert.equal(running.size, 0));
  await until(async () => assert.equal(await openStreams(), 1));
  await page.goto('about:blank');
  await until(async () => assert.equal(await openStreams(), 0));
  add('DatabaseService.WatchDatabase CANCELLED');
  const { status } = await call(setup.open, 'ClipService/GetClip', {
    name: 'databases/demo/clips/none',
  });
  assert.equal(status, 404);
  add('ClipService.GetClip NOT_FOUND');
  assert.ok(expected['ClipService.ListClips OK'] > 0);
  await until(async () => {
    const calls = await callsSince(before);
    for (const [name, count] of Object.entries(expected)) assert.equal(calls[name], count, name);
    assert.equal((await durations()) - timed, expected['ClipService.ListClips OK']);
  });
});
