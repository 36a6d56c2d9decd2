// The page over the server's own TLS.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';
import { logIn, newPage } from './support/browser.mjs';
import { OwnServer } from './support/own_server.mjs';
import { setup } from './support/setup.mjs';

const run = promisify(execFile);
const server = new OwnServer(join(setup.folder, 'tls.db'));

before(async () => {
  await server.start();
  await server.fill();
  await server.stop();
  const [certificate, key] = ['tls.crt', 'tls.key'].map((name) => join(setup.folder, name));
  await run('openssl', [
    ...['req', '-x509', '-newkey', 'ec', '-pkeyopt', 'ec_paramgen_curve:prime256v1', '-nodes'],
    ...['-days', '2', '-subj', '/CN=motiondb', '-addext', 'subjectAltName=IP:127.0.0.1'],
    ...['-keyout', key, '-out', certificate],
  ]);
  await server.start(
    ...['--tls-certificate', certificate, '--tls-key', key],
    ...['--authentication', 'token', '--admin-token-file', join(setup.folder, 'token')],
  );
});
after(() => server.stop());

test('login, a clip that plays, and logout over TLS', async (t) => {
  assert.match(server.url, /^https:/);
  const page = await newPage(t, { server: server.url, ignoreHTTPSErrors: true });
  await page.goto(`${server.url}/#/clip/own/01_01`);
  await logIn(page, setup.adminToken);
  await page.locator('.timeline').getByText('jump').first().waitFor();
  const [cookie, ...others] = await page.context().cookies();
  assert.deepEqual(others, []);
  assert.equal(cookie.name, '__Host-motiondb_token');
  assert.deepEqual([cookie.secure, cookie.httpOnly, cookie.sameSite], [true, true, 'Strict']);
  await page.getByRole('button', { name: 'Play' }).click();
  await page.getByRole('button', { name: 'Pause' }).click();
  await page.reload();
  await page.locator('.timeline').getByText('jump').first().waitFor();
  await page.getByRole('button', { name: 'Log out' }).click();
  await page.locator('input[name=token]').waitFor();
  assert.deepEqual(await page.context().cookies(), []);
});
