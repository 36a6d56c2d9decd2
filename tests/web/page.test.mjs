// The page opens, with its security headers, in both themes.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, newPage, shown } from './support/browser.mjs';
import { isBusy } from './support/busy.mjs';
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

test('the policy stops inline code, eval, foreign images and frames', async (t) => {
  const page = await newPage(t, { expected: [/Content Security Policy/, /foreign host/] });
  await page.goto(`${setup.open}/`);
  await shown(page);
  const result = await page.evaluate(async () => {
    const violations = [];
    document.addEventListener('securitypolicyviolation', (event) => {
      violations.push(event.effectiveDirective);
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
    await fetch('http://foreign.invalid/').catch(() => {});
    await new Promise((resolve) => setTimeout(resolve, 1000));
    return { violations, hacked: window.hacked };
  });
  assert.equal(result.hacked, undefined);
  for (const directive of ['img-src', 'frame-src', 'connect-src'])
    assert.ok(result.violations.includes(directive), `${directive}: ${result.violations}`);
  assert.ok(result.violations.some((directive) => directive.startsWith('script-src')));
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
