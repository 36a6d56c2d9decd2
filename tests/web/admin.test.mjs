// The view of the server: status, operations, downloads, tokens and audit log (by role: roles).
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { join } from 'node:path';
import { test } from 'node:test';
import { promisify } from 'node:util';
import { checkAccessibility, logIn, newPage, until } from './support/browser.mjs';
import { lineValues, recordCharts } from './support/charts.mjs';
import { modelOperation, storeManyClips } from './support/many_clips.mjs';
import { OwnServer } from './support/own_server.mjs';
import { call, createToken, revokeToken } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { watch } from './support/stream.mjs';

async function openAsAdmin(t, options) {
  const page = await newPage(t, options);
  await page.goto(`${setup.secure}/#/admin`);
  await logIn(page, setup.adminToken);
  return page;
}

let restored = 0;

const section = (page, name) => page.getByRole('region', { name, exact: true });

test('an administrator creates a token and revokes it with the keyboard', async (t) => {
  const page = await openAsAdmin(t);
  const tokens = section(page, 'Tokens');
  await tokens.getByLabel('Purpose').fill(setup.hostile);
  await tokens.getByRole('button', { name: 'Create token' }).press('Enter');
  const secret = await tokens.locator('code.secret').textContent();
  const row = tokens.locator('tbody tr', { hasText: setup.hostile });
  await row.waitFor();
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  await checkAccessibility(page);
  const session = () =>
    fetch(`${setup.secure}/session`, { headers: { authorization: `Bearer ${secret}` } });
  assert.equal((await (await session()).json()).role, 'reader');
  await row.getByRole('button', { name: /Revoke/ }).press('Enter');
  await row.getByRole('button').waitFor({ state: 'detached' });
  assert.notEqual((await (await session()).json()).authenticated, true);
});

test('the audit log has the calls of the page', async (t) => {
  const { name } = await createToken('ROLE_READER');
  await revokeToken(name);
  const page = await openAsAdmin(t);
  const entry = section(page, 'Audit log').locator('tbody tr', { hasText: 'RevokeToken' });
  assert.match(await entry.filter({ hasText: name }).textContent(), /ok/);
});

test('status, operations and downloads of a server without tokens', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/admin`);
  const { body } = await call(setup.open, 'ServerService/GetServerStatus', {});
  const facts = section(page, 'Status').locator('dl');
  await facts.getByText(body.version).waitFor();
  await facts.getByText('DISABLED').waitFor();
  await section(page, 'Status').getByRole('link', { name: 'demo' }).waitFor();
  await section(page, 'Status').locator('.chart canvas').nth(3).waitFor();
  await section(page, 'Operations').locator('tr', { hasText: 'demo' }).first().waitFor();
  await checkAccessibility(page);
  // A table that is drawn again keeps the focus.
  const link = section(page, 'Status').getByRole('link', { name: 'demo' });
  await link.focus();
  const drawn = await link.elementHandle();
  await page.waitForFunction((node) => !node.isConnected, drawn);
  assert.equal(await page.evaluate(() => document.activeElement.textContent), 'demo');
  const downloads = section(page, 'Downloads');
  await downloads.locator('option[value=demo]').waitFor({ state: 'attached' });
  await downloads.getByLabel('Database').selectOption('demo');
  for (const [button, file] of [
    ['Download database', 'demo.motiondb'],
    ['Download backup of the store', 'motiondb.backup'],
  ]) {
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      downloads.getByRole('button', { name: button }).click(),
    ]);
    assert.equal(download.suggestedFilename(), file);
    await checkRestored(t, await download.path());
  }
});

// A server without databases restores the file, and has the clips of the database `demo`.
async function checkRestored(t, file) {
  const server = new OwnServer(join(setup.folder, `${++restored}.restored.db`));
  await server.start();
  t.after(() => server.stop());
  await promisify(execFile)(setup.motiondb, ['--server', server.address, 'restore', file]);
  const clipsOf = async (url) => {
    const { body } = await call(url, 'ClipService/ListClips', { parent: 'databases/demo' });
    return body.clips.map(({ name, frameCount, label }) => [name, frameCount, label]);
  };
  const clips = await clipsOf(server.url);
  assert.ok(clips.length >= 3);
  assert.deepEqual(clips, await clipsOf(setup.open));
  await server.stop();
}

test('the charts show what the server reports', async (t) => {
  const page = await newPage(t);
  await recordCharts(page);
  await page.goto(`${setup.open}/#/admin`);
  const status = section(page, 'Status');
  const values = (name) => lineValues(status.getByRole('img', { name }).locator('canvas'));
  const last = async (name) => (await values(name))[0].at(-1);
  const most = async (name) => Math.max(...(await values(name))[0]);
  await status.locator('.chart canvas').nth(3).waitFor();
  // A chart of one sample has no scale.
  await until(async () => assert.ok((await last('Processor cores in use')) > 0), 60);
  const cores = status.locator('dt', { hasText: 'Processor cores in use' });
  await until(async () => {
    const text = await cores.locator('+ dd').textContent();
    assert.ok(Math.abs(Number(text) - (await last('Processor cores in use'))) <= 0.005, text);
  });
  assert.ok((await most('Calls per second')) < 50);

  const controller = new AbortController();
  t.after(() => controller.abort());
  const read = async () => {
    const stream = watch(
      setup.open,
      'DatabaseService/WatchDatabase',
      { name: 'databases/demo' },
      controller.signal,
    );
    for await (const message of stream) assert.ok(message);
  };
  for (let i = 0; i < 7; ++i) read().catch(() => {}); // ends with the test
  // Seven streams, the call that reads the count, and others of the page at that moment.
  await until(async () => {
    const open = await last('Open calls');
    assert.ok(open > 7.5 && open < 12.5, `${open} open calls`);
  }, 60);

  const burst = Array.from({ length: 400 }, () =>
    call(setup.open, 'ServerService/GetServerStatus', {}),
  );
  await Promise.all(burst);
  await until(async () => assert.ok((await most('Calls per second')) > 50), 60);
  await until(async () => {
    const { body } = await call(setup.open, 'ServerService/GetServerStatus', {});
    const memory = await last('Memory of the server');
    assert.ok(Math.abs(memory / (Number(body.memoryBytes) / 2 ** 20) - 1) < 0.1, `${memory} MiB`);
  }, 60);
});

// Lets the page read the operations five times a second, to see more of their progress.
const pollFast = (page) =>
  page.addInitScript(() => {
    const original = window.setTimeout;
    window.setTimeout = (call, delay, ...more) =>
      original(call, delay === 1500 ? 200 : delay, ...more);
  });

// Reads the row of the operation that runs for `many` until it shows `count` values of progress that
// rise. Each must be one that the server has reached.
async function watchProgress(page, count) {
  const values = [];
  const stages = new Set();
  const end = performance.now() + 60_000;
  while (values.length < count) {
    assert.ok(performance.now() < end, `${count} values of progress, got ${values}`);
    const shown = await page.evaluate(() => {
      const rows = [...document.querySelectorAll('section[aria-label="Operations"] tbody tr')];
      const row = rows.find((each) => each.cells[0].textContent === 'many');
      const bar = row?.querySelector('progress');
      const [, kind, state] = row ? [...row.cells].map((cell) => cell.textContent) : [];
      return bar ? { value: bar.value, stage: bar.getAttribute('aria-label'), kind, state } : null;
    });
    // The page may show an operation that has just ended.
    const { progress = 0 } = (await modelOperation()) ?? { progress: 1 };
    if (shown && shown.value > (values.at(-1) ?? 0)) {
      assert.ok(shown.value <= progress && shown.value < 1, `${shown.value} of ${progress}`);
      assert.equal(shown.state, shown.stage);
      stages.add(`${shown.kind}: ${shown.stage}`);
      values.push(shown.value);
    } else if (shown) {
      assert.equal(shown.value, values.at(-1) ?? 0, 'progress does not fall');
    }
    await page.waitForTimeout(20);
  }
  return [...stages].join('; ');
}

test('operations show their progress while they run, and are cancelled', async (t) => {
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await pollFast(page);
  await page.goto(`${setup.open}/#/admin`);
  const operations = section(page, 'Operations');
  await operations.locator('tbody tr', { hasText: 'succeeded' }).first().waitFor();
  const cancel = async () => {
    const { name } = await modelOperation();
    const row = operations.locator('tbody tr', { hasText: 'many' }).first();
    await row.getByRole('button', { name: 'Cancel' }).click();
    await row.getByText('cancelled').waitFor();
    assert.equal(await row.locator('progress, button').count(), 0);
    const { body } = await call(setup.open, 'OperationService/GetOperation', { name });
    assert.equal(body.operation.state, 'OPERATION_STATE_CANCELLED');
  };
  await storeManyClips();
  assert.match(await watchProgress(page, 3), /update model: /);
  await cancel();
  await call(setup.open, 'DatabaseService/ReprocessDatabase', { name: 'databases/many' });
  assert.match(
    await watchProgress(page, 2),
    /derive clips again: deriving clips again, \d+ of 200/,
  );
  await cancel();
});
