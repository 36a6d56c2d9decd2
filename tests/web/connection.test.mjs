// A server that stops and starts again while a view is open.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { drop, newPage, until } from './support/browser.mjs';
import { OwnServer } from './support/own_server.mjs';
import { setup } from './support/setup.mjs';

const server = new OwnServer(join(setup.folder, 'own.db'));

before(async () => {
  await server.start();
  await server.fill();
});
after(() => server.stop());

const lost = { expected: [/Failed to load resource/, /ERR_/] };
const banner = (page) => page.getByText('Connection lost.', { exact: false });

async function open(t, place) {
  const page = await newPage(t, { ...lost, server: server.url });
  await page.goto(`${server.url}/#/${place}`);
  return page;
}

// The place of a view, the same view at another place, and its data.
const views = [
  ['clips', 'clips/own', 'clips/own?order=label', (page) => page.locator('main tbody tr').first()],
  [
    'clip',
    'clip/own/01_01',
    'clip/own/01_01?t=1',
    (page) => page.locator('.timeline').getByText('jump').first(),
  ],
  [
    'database',
    'database/own',
    'database/own?layer=1',
    (page) => page.getByText('Variance along').first(),
  ],
];

for (const [name, place, other, data] of views) {
  test(`the view ${name} that fails without a server recovers without a click`, async (t) => {
    const page = await open(t, place);
    await data(page).waitFor();
    await server.stop(name === 'clip' ? 'SIGKILL' : 'SIGTERM');
    try {
      // The database view makes no call that could fail.
      await banner(page).waitFor();
      await page.evaluate((hash) => {
        location.hash = hash;
      }, `/${other}`);
      await page.locator('main .notice.error').first().waitFor();
      assert.equal(await data(page).count(), 0);
    } finally {
      await server.start();
    }
    await data(page).waitFor();
    await banner(page).waitFor({ state: 'detached' });
    await page.waitForFunction(
      () => document.querySelectorAll('.notice.error:not([hidden])').length === 0,
    );
  });
}

test('a prediction that is asked for several times without a server is made once', async (t) => {
  const page = await open(t, 'query/own?clip=01_01&from=1&to=4&at=1&without=0');
  const section = page.getByRole('region', { name: 'Estimation and prediction' });
  await section.locator('tbody tr').first().waitFor();
  await section.getByRole('button', { name: 'Remove prediction' }).click();
  let predictions = 0;
  await server.stop();
  try {
    for (let i = 0; i < 3; ++i) {
      await section.getByRole('button', { name: 'Predict from this moment' }).click();
      await section.locator('.notice.error').waitFor();
    }
    page.on('request', (request) => {
      if (request.url().endsWith('/Predict')) ++predictions;
    });
  } finally {
    await server.start();
  }
  await section.locator('tbody tr').first().waitFor();
  assert.equal(predictions, 1);
});

test('a view whose scripts could not be loaded opens when the server is back', async (t) => {
  const page = await open(t, 'clips/own');
  await page.locator('main tbody tr').first().waitFor();
  await server.stop();
  try {
    await page.evaluate(() => {
      location.hash = '/database/own';
    });
    await page.locator('main .notice.error').first().waitFor();
    await banner(page).waitFor();
  } finally {
    await server.start();
  }
  await page.getByText('Variance along').first().waitFor();
  assert.equal(await banner(page).count(), 0);
});

// A proxy or an extension of the browser can block scripts of a page whose server answers.
test('a view whose scripts stay blocked loads the page again once, and shows the error', async (t) => {
  const page = await open(t, 'clips/own');
  await page.locator('main tbody tr').first().waitFor();
  await page.route('**/assets/database_view-*.js', (route) => route.abort());
  let loads = 0;
  page.on('load', () => ++loads);
  await page.evaluate(() => {
    location.hash = '/database/own';
  });
  const error = page.locator('main .notice.error', { hasText: 'scripts of this view' });
  await until(() => assert.equal(loads, 1));
  await error.waitFor();
  await page.waitForTimeout(5000);
  assert.deepEqual([loads, await error.count(), await banner(page).count()], [1, 1, 0]);
  assert.equal(await page.title(), 'Database - motiondb');
  await page.getByRole('link', { name: 'Clips' }).click();
  await page.locator('main tbody tr').first().waitFor();
  await page.goBack();
  await until(() => assert.equal(loads, 2));
  await error.waitFor();
  await page.unroute('**/assets/database_view-*.js');
  await error.getByRole('button', { name: 'Try again' }).click();
  await page.getByText('Variance along').first().waitFor();
});

test('an upload that takes long, and delays the check of the session, is no lost connection', async (t) => {
  const page = await open(t, 'clips/own');
  await page.locator('main tbody tr').first().waitFor();
  let uploads = 0;
  await page.route('**/UploadClip', async (route) => {
    ++uploads;
    await new Promise((resolve) => setTimeout(resolve, 12_000));
    await route.abort();
  });
  let checks = 0;
  await page.route('**/session', () => ++checks); // no answer
  await drop(page.locator('main'), 'large.bvh', Buffer.alloc(2 << 20, ' '));
  await until(() => assert.deepEqual([uploads, checks], [1, 1]));
  await page.waitForTimeout(7000);
  assert.equal(await banner(page).count(), 0);
  await page.getByText('does not answer').first().waitFor(); // of the upload
  await banner(page).waitFor();
});

test('a server that hangs is reported, and the view goes on when it answers', async (t) => {
  const page = await open(t, 'database/own');
  await page.getByText('Variance along').first().waitFor();
  server.process.kill('SIGSTOP');
  try {
    await banner(page).waitFor();
  } finally {
    server.process.kill('SIGCONT');
  }
  await banner(page).waitFor({ state: 'detached' });
  await page.evaluate(() => {
    location.hash = '/clips/own';
  });
  await page.locator('main tbody tr').first().waitFor();
});

test('a page that loads while a proxy does not reach the server opens later', async (t) => {
  const page = await newPage(t, { ...lost, server: server.url });
  await page.route('**/session', (route) => route.fulfill({ status: 502, body: 'Bad gateway' }));
  await page.goto(`${server.url}/#/clips/own`);
  await page.locator('.notice.error', { hasText: 'does not answer' }).waitFor();
  await page.unroute('**/session');
  await page.locator('main tbody tr').first().waitFor();
  assert.equal(await page.locator('.notice.error:visible').count(), 0);
});
