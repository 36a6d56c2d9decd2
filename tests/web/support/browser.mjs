// A browser for the tests of one file. Every page reports errors of its console, exceptions and
// requests to foreign hosts; a test fails if there is one that it does not expect.
import assert from 'node:assert/strict';
import { after } from 'node:test';
import { requirePackage, setup } from './setup.mjs';

const { chromium } = requirePackage('playwright-core');
const axe = requirePackage('axe-core');

const kPatience = 90_000; // ms, for each step of a test

// Pixels of the picture per CSS pixel: the processor draws them. Tests that read pixels set 1.
const kScale = 0.5;

let browser;

async function launch() {
  browser ??= await chromium.launch({
    executablePath: setup.chromium,
    args: [
      ...(process.getuid?.() === 0 ? ['--no-sandbox'] : []),
      '--use-gl=angle',
      '--use-angle=swiftshader',
      '--enable-unsafe-swiftshader',
      // Otherwise a busy machine gets one picture a second, for which every click waits.
      '--disable-gpu-vsync',
      '--disable-dev-shm-usage',
    ],
  });
  return browser;
}

after(async () => {
  await browser?.close();
});

/**
 * Opens a page without a URL. `expected`: patterns of errors that the test provokes. `server`: URL
 * of another server that the page may call. `options`: of browser.newContext, for example
 * {colorScheme: 'dark', viewport: {width: 800, height: 600}}; the scale is kScale unless given.
 */
export async function newPage(t, { expected = [], context, server, ...options } = {}) {
  const owner =
    context ?? (await (await launch()).newContext({ deviceScaleFactor: kScale, ...options }));
  const page = await owner.newPage();
  // A busy machine is no error: the whole run has a limit (web_page_test.py).
  page.setDefaultTimeout(kPatience);
  if (process.env.MOTIONDB_WEB_THROTTLE) {
    const session = await owner.newCDPSession(page);
    const rate = Number(process.env.MOTIONDB_WEB_THROTTLE);
    await session.send('Emulation.setCPUThrottlingRate', { rate });
  }
  const errors = [];
  const report = (error) => {
    if (!expected.some((pattern) => pattern.test(error))) errors.push(error);
  };
  page.on('console', (message) => {
    const level = message.type();
    if (level === 'error' || level === 'warning')
      report(`console ${level}: ${message.text()} (${message.location().url})`);
  });
  page.on('pageerror', (error) => report(`exception: ${error.stack ?? error}`));
  page.on('dialog', (dialog) => {
    report(`dialog: ${dialog.message()}`);
    void dialog.dismiss();
  });
  page.on('request', (request) => {
    const url = new URL(request.url());
    const servers = [setup.open, setup.secure, setup.large?.web, server];
    const own = servers.includes(url.origin) || url.protocol === 'blob:';
    if (!own && url.protocol !== 'data:') report(`request to a foreign host: ${url.href}`);
  });
  t.after(async () => {
    if (context === undefined) await owner.close();
    else await page.close();
    assert.deepEqual(errors, []);
  });
  return page;
}

// The pages that `page` opens later have no WebGL.
export async function disableWebGL(page) {
  await page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (kind, ...more) {
      return kind.startsWith('webgl') ? null : original.call(this, kind, ...more);
    };
  });
}

// Waits until the page has drawn its frame: navigation or login.
export async function shown(page) {
  await page.locator('main').waitFor();
  await page.waitForFunction(() => (document.querySelector('main')?.childElementCount ?? 0) > 0);
}

// Waits until the view has not changed for half a second. Views keep streams of changes open, so the
// network is never idle.
export async function settled(page) {
  await page.evaluate(
    () =>
      new Promise((resolve) => {
        let timer = setTimeout(resolve, 500);
        const observer = new MutationObserver(() => {
          clearTimeout(timer);
          timer = setTimeout(resolve, 500);
        });
        observer.observe(document.querySelector('main'), { childList: true, subtree: true });
      }),
  );
}

// Fails if axe finds a violation of WCAG 2.2 A or AA, or of its best practices.
export async function checkAccessibility(page) {
  await page.evaluate(axe.source);
  const violations = await page.evaluate(async () => {
    const result = await globalThis.axe.run(document);
    return result.violations.map(
      (violation) =>
        `${violation.id}: ${violation.help}: ` +
        violation.nodes.map((node) => `${node.html} ${node.failureSummary}`).join('; '),
    );
  });
  assert.deepEqual(violations, []);
}

// Waits until `check` does not throw; returns its result.
export async function until(check, seconds = 5) {
  const end = performance.now() + 1000 * seconds;
  for (;;) {
    try {
      return await check();
    } catch (error) {
      if (performance.now() > end) throw error;
    }
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

// Drops a file on a part of the page.
export async function drop(target, name, buffer) {
  const transfer = await target.page().evaluateHandle(
    ([fileName, text]) => {
      const transfer = new DataTransfer();
      const data = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
      transfer.items.add(new File([data], fileName));
      return transfer;
    },
    [name, buffer.toString('base64')],
  );
  await target.dispatchEvent('drop', { dataTransfer: transfer });
}

// Logs in with the form of the page.
export async function logIn(page, token) {
  await page.locator('input[name=token]').fill(token);
  await page.locator('button[type=submit]').click();
}
