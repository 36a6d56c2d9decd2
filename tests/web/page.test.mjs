// The page opens, with its security headers, in both themes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage, shown } from './support/browser.mjs';
import { isBusy } from './support/busy.mjs';
import { motiondb } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const policy =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; " +
  "connect-src 'self'; base-uri 'none'; " +
  "form-action 'none'; frame-ancestors 'none'";

test('opens at / without an error', async (t) => {
  const page = await newPage(t);
  const response = await page.goto(`${setup.open}/`);
  assert.equal(response.status(), 200);
  const headers = response.headers();
  assert.equal(headers['content-security-policy'], policy);
  assert.equal(headers['x-content-type-options'], 'nosniff');
  assert.equal(headers['referrer-policy'], 'no-referrer');
  assert.equal(headers['cross-origin-opener-policy'], 'same-origin');
  await shown(page);
  assert.match(await page.title(), /motiondb/);
});

test('the first view appears within 1 s', async (t) => {
  const page = await newPage(t);
  const row = page.locator('main tbody tr').first();
  await page.goto(`${setup.open}/`);
  await row.waitFor(); // also fills the caches of the server
  await page.goto('about:blank');
  const began = performance.now();
  await page.goto(`${setup.open}/`);
  await row.waitFor();
  const milliseconds = performance.now() - began;
  t.diagnostic(`first view after ${milliseconds.toFixed(0)} ms`);
  if (!isBusy()) assert.ok(milliseconds < 1000);
});

test('a deep path gives the page, an unknown file is not found', async (t) => {
  const page = await newPage(t);
  const response = await page.goto(`${setup.open}/some/view`);
  assert.equal(response.status(), 200);
  assert.match(response.headers()['content-type'], /^text\/html/);
  assert.equal((await fetch(`${setup.open}/assets/none.js`)).status, 404);
});

test('the theme button offers the other theme when the system changes', async (t) => {
  const page = await newPage(t, { colorScheme: 'light' });
  await page.goto(`${setup.open}/#/clips/demo`);
  await page.getByRole('button', { name: 'Dark' }).waitFor();
  await page.emulateMedia({ colorScheme: 'dark' });
  await page.getByRole('button', { name: 'Light' }).click();
  await page.getByRole('button', { name: 'Dark' }).waitFor();
  assert.equal(await page.locator('html').getAttribute('data-theme'), 'light');
});

test('a database that is new is chosen without a reload', async (t) => {
  const page = await newPage(t);
  await page.goto(`${setup.open}/#/clips/demo`);
  await shown(page);
  await motiondb('create', 'zz_new');
  t.after(() => motiondb('delete', 'zz_new', '--yes'));
  await page.evaluate(() => (location.hash = '#/clips/zz_new'));
  await page.getByText('0 clips').waitFor();
  const database = page.getByLabel('Database');
  await database.locator('option', { hasText: 'zz_new' }).waitFor({ state: 'attached' });
  assert.equal(await database.inputValue(), 'zz_new');
});

test('the policy stops inline code, eval, foreign images and frames', async (t) => {
  const page = await newPage(t, { expected: [/Content Security Policy/, /foreign host/] });
  await page.goto(`${setup.open}/`);
  await shown(page);
  await page.evaluate(() => {
    window.violations = [];
    document.addEventListener('securitypolicyviolation', (event) => {
      window.violations.push(event.effectiveDirective);
    });
    const script = document.createElement('script');
    script.textContent = 'window.hacked = 1';
    document.body.append(script);
    const image = document.createElement('img');
    image.src = 'http://foreign.invalid/a.png';
    document.body.append(image);
    document.body.setAttribute('onclick', 'window.hacked = 1');
    document.body.click();
    const timer = document.createElement('a');
    timer.href = 'javascript:window.hacked=1';
    document.body.append(timer);
    timer.click();
    const frame = document.createElement('iframe');
    frame.src = 'http://foreign.invalid/';
    document.body.append(frame);
    void fetch('http://foreign.invalid/').catch(() => {});
  });
  // The script, the attribute and the link are scripts.
  await page.waitForFunction(() => {
    const count = (begin) => window.violations.filter((each) => each.startsWith(begin)).length;
    const others = ['img-src', 'frame-src', 'connect-src'];
    return count('script-src') >= 3 && others.every((directive) => count(directive) >= 1);
  });
  assert.equal(await page.evaluate(() => window.hacked), undefined);
});

test('a server that is older than the page says so', async (t) => {
  const page = await newPage(t, { expected: [/status of 404/] });
  await page.route('**/motiondb.v1.ViewService/**', (route) => route.fulfill({ status: 404 }));
  await page.goto(`${setup.open}/#/clip/demo/01_01`);
  await page.getByText('because it is older than this page').first().waitFor();
});

for (const colorScheme of ['light', 'dark']) {
  test(`axe reports nothing at the login in the ${colorScheme} theme`, async (t) => {
    const page = await newPage(t, { colorScheme });
    await page.goto(`${setup.secure}/`);
    await page.locator('input[name=token]').waitFor();
    await checkAccessibility(page);
  });
}

test('the focus goes to the heading of a view that the user opens', async (t) => {
  const page = await newPage(t);
  const hasFocus = (locator) => locator.evaluate((node) => node === document.activeElement);
  await page.goto(`${setup.open}/`);
  const link = page.getByRole('link', { name: '01_03' });
  await link.waitFor();
  assert.ok(await hasFocus(page.locator('body')), 'a page that opens moves no focus');
  await link.press('Enter');
  await page.locator('.segment-body').first().waitFor();
  assert.ok(await hasFocus(page.getByRole('heading', { level: 1, name: '01_03' })));
  await page.keyboard.press('.');
  await page.locator('.position', { hasText: 'frame 1' }).waitFor();
  // A menu keeps the focus; screen readers say the heading.
  const menu = page.getByLabel('Database');
  await menu.focus();
  await menu.selectOption('hostile');
  await page.locator('[aria-live]', { hasText: 'Clips of hostile' }).waitFor();
  assert.ok(await hasFocus(menu));
});
