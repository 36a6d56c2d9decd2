// Login with the form, logout, a token that is revoked during use, and requests that other sites
// forge.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { test } from 'node:test';
import { logIn, newPage, settled, shown } from './support/browser.mjs';
import { call, createToken, revokeToken } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const refused = [/status of 401/, /status of 403/];

async function databases() {
  const { body } = await call(setup.secure, 'DatabaseService/ListDatabases', {});
  return (body.databases ?? []).map((database) => database.name);
}

test('a wrong token is refused with the reason', async (t) => {
  const page = await newPage(t, { expected: refused });
  await page.goto(`${setup.secure}/`);
  await logIn(page, 'mdb_0123456789ab_wrong');
  await page.getByText('the token is not one of this server').waitFor();
  assert.deepEqual(await page.context().cookies(), []);
});

test('login, reload, logout', async (t) => {
  const { secret, name } = await createToken('ROLE_READER');
  const page = await newPage(t);
  await page.goto(`${setup.secure}/`);
  await logIn(page, secret);
  await page.getByText(name).first().waitFor();
  const [cookie] = await page.context().cookies();
  assert.equal(cookie.httpOnly, true);
  assert.equal(cookie.sameSite, 'Strict');
  assert.equal(cookie.path, '/');
  assert.equal(await page.evaluate(() => document.cookie), '');
  const stored = await page.evaluate(
    () => JSON.stringify({ ...localStorage }) + JSON.stringify({ ...sessionStorage }),
  );
  assert.ok(!stored.includes(secret));
  assert.ok(!(await page.content()).includes(secret));
  await page.reload();
  await page.getByText(name).first().waitFor();
  await page.getByRole('button', { name: 'Log out' }).click();
  await page.locator('input[name=token]').waitFor();
  assert.deepEqual(await page.context().cookies(), []);
});

test('a revoked token ends the session', async (t) => {
  const { secret, name } = await createToken('ROLE_READER');
  const page = await newPage(t, { expected: refused });
  await page.goto(`${setup.secure}/`);
  await logIn(page, secret);
  await page.getByText(name).first().waitFor();
  await revokeToken(name);
  const status = await page.evaluate(async () => {
    const response = await fetch('/motiondb.v1.DatabaseService/ListDatabases', {
      method: 'POST',
      headers: { 'content-type': 'application/json', 'connect-protocol-version': '1' },
      body: '{}',
    });
    return response.status;
  });
  assert.equal(status, 401);
  await page.reload();
  await page.locator('input[name=token]').waitFor();
  assert.deepEqual(await page.context().cookies(), []);
});

test('a page that opens with a revoked token shows why it asks for another one', async (t) => {
  const { secret, name } = await createToken('ROLE_READER');
  const page = await newPage(t);
  await page.goto(`${setup.secure}/`);
  await logIn(page, secret);
  await page.getByText(name).first().waitFor();
  await page.goto('about:blank');
  await revokeToken(name);
  await page.goto(`${setup.secure}/`);
  await page.getByText(`Log in again: ${name} was revoked.`).waitFor();
});

test('the form of the login stays when the address changes', async (t) => {
  const page = await newPage(t, { expected: refused });
  await page.goto(`${setup.secure}/#/admin`);
  const form = page.locator('input[name=token]');
  await form.waitFor();
  await page.getByRole('link', { name: 'motiondb' }).click();
  await page.waitForURL(/#\/$/);
  await form.fill(setup.adminToken);
  await page.goBack();
  assert.equal(await form.inputValue(), setup.adminToken);
  assert.equal(await page.locator('.notice.error:visible').count(), 0);
  await page.locator('button[type=submit]').click();
  await page.getByRole('heading', { name: 'Audit log' }).waitFor();
});

// The other site has another port of the same host: SameSite=Strict does not keep the cookie back.
test('forged requests of other origins change nothing', async (t) => {
  const page = await newPage(t, { expected: [/.*/] });
  await page.goto(`${setup.secure}/`);
  await logIn(page, setup.adminToken);
  await page.waitForFunction(() => document.querySelector('input[name=token]') === null);
  const target = `${setup.secure}/motiondb.v1.DatabaseService/CreateDatabase`;
  const site = createServer((_, response) => {
    response.setHeader('content-type', 'text/html');
    response.end(
      `<form id=f method=post enctype=text/plain action="${target}">` +
        `<input name='{"databaseId":"forged-form","x":"' value='"}'></form>`,
    );
  });
  await new Promise((resolve) => site.listen(0, '127.0.0.1', resolve));
  t.after(() => site.close());
  const foreign = `http://127.0.0.1:${site.address().port}/`;
  await page.goto(foreign);
  const outcomes = await page.evaluate(async (url) => {
    const body = JSON.stringify({ databaseId: 'forged-fetch' });
    const attempt = (options) =>
      fetch(url, { method: 'POST', credentials: 'include', body, ...options }).then(
        (response) => response.type,
        () => 'refused',
      );
    return [
      await attempt({ mode: 'no-cors', headers: { 'content-type': 'text/plain' } }),
      await attempt({ headers: { 'content-type': 'application/json' } }),
      await attempt({
        headers: { 'content-type': 'application/json', 'connect-protocol-version': '1' },
      }),
    ];
  }, target);
  assert.deepEqual(outcomes, ['opaque', 'refused', 'refused']);
  const [response] = await Promise.all([
    page.waitForResponse((candidate) => candidate.url() === target),
    page.evaluate(() => document.querySelector('#f').submit()),
  ]);
  assert.equal(response.status(), 415);
  assert.deepEqual(await databases(), []);

  // What a browser cannot send, refused too: the cookie with the Origin of another site.
  const [cookie] = await page.context().cookies(setup.secure);
  const forged = (headers) =>
    fetch(target, {
      method: 'POST',
      headers: {
        cookie: `${cookie.name}=${cookie.value}`,
        'content-type': 'application/json',
        ...headers,
      },
      body: JSON.stringify({ databaseId: 'forged' }),
    });
  for (const headers of [
    {},
    { 'connect-protocol-version': '1', origin: 'https://evil.example' },
    { 'connect-protocol-version': '1', origin: foreign.slice(0, -1) },
  ]) {
    const answer = await forged(headers);
    assert.equal(answer.status, 403);
    assert.equal((await answer.json()).code, 'permission_denied');
  }
  assert.deepEqual(await databases(), []);
});

test('the page cannot be framed by another site', async (t) => {
  const page = await newPage(t, { expected: [/.*/] });
  const site = createServer((_, response) => {
    response.setHeader('content-type', 'text/html');
    response.end(`<iframe src="${setup.open}/"></iframe>`);
  });
  await new Promise((resolve) => site.listen(0, '127.0.0.1', resolve));
  t.after(() => site.close());
  const [refusal] = await Promise.all([
    page.waitForEvent('requestfailed', (request) => request.url() === `${setup.open}/`),
    page.goto(`http://127.0.0.1:${site.address().port}/`),
  ]);
  assert.equal(refusal.failure().errorText, 'net::ERR_BLOCKED_BY_RESPONSE');
  assert.ok(page.frames().every((frame) => !frame.url().startsWith(setup.open)));
});

test('two browsers have sessions of their own', async (t) => {
  const reader = await createToken('ROLE_READER');
  const first = await newPage(t);
  const second = await newPage(t);
  for (const page of [first, second]) await page.goto(`${setup.secure}/`);
  await logIn(first, reader.secret);
  await first.getByText(reader.name).first().waitFor();
  await shown(second);
  assert.equal(await second.locator('input[name=token]').count(), 1);
});

// The tabs of a browser share its login.
test('a login in another tab changes what the page offers', async (t) => {
  const reader = await createToken('ROLE_READER');
  const first = await newPage(t);
  const second = await newPage(t, { context: first.context() });
  await first.goto(`${setup.secure}/#/admin`);
  await first.locator('input[name=token]').waitFor();
  assert.equal(await first.title(), 'Log in - motiondb');
  const audit = first.getByRole('heading', { name: 'Audit log' });
  await logIn(first, setup.adminToken);
  await audit.waitFor();
  assert.equal(await first.title(), 'Server - motiondb');
  const logInSecond = async (token) => {
    await second.goto(`${setup.secure}/`);
    await second.getByRole('button', { name: 'Log out' }).click();
    await logIn(second, token);
  };
  await logInSecond(reader.secret);
  await first.locator('header', { hasText: reader.name }).waitFor();
  await first.getByRole('heading', { name: 'Status' }).waitFor();
  assert.equal(await audit.count(), 0);
  await logInSecond(setup.adminToken);
  await audit.waitFor();
  assert.equal(await first.locator('header', { hasText: reader.name }).count(), 0);
});

// Stores a database with a clip, for one test. Returns the operation that builds its model.
async function storePrivate(t) {
  await call(setup.secure, 'DatabaseService/CreateDatabase', { databaseId: 'private' });
  t.after(() =>
    call(setup.secure, 'DatabaseService/DeleteDatabase', { name: 'databases/private' }),
  );
  const file = (await readFile(`${setup.models}/01_01.bvh`)).toString('base64');
  const header = { parent: 'databases/private', fileName: '01_01.bvh' };
  const { body } = await call(setup.secure, 'ClipService/UploadClip', { header, file });
  return body.operation;
}

// A reader of a clip loses the token: the page asks for another one, then shows the same place.
test('a token revoked while a view is open', async (t) => {
  const page = await newPage(t, { expected: refused });
  await storePrivate(t);
  const first = await createToken('ROLE_READER');
  const second = await createToken('ROLE_READER');
  await page.goto(`${setup.secure}/#/clip/private/01_01?t=2&show=markers`);
  await logIn(page, first.secret);
  await page.locator('.position', { hasText: 'frame 120' }).waitFor();
  assert.equal(await page.getByRole('button', { name: 'Edit', exact: true }).count(), 0);
  await revokeToken(first.name);
  // Reads the names of the clips, unless the page asks for a token already.
  await page.evaluate(() => document.querySelector('input[list=compare-clips]')?.focus());
  await page.locator('input[name=token]').waitFor();
  assert.equal(await page.locator('.scene').count(), 0);
  await logIn(page, second.secret);
  await page.getByText(second.name).first().waitFor();
  await page.locator('.position', { hasText: 'frame 120' }).waitFor();
  assert.match(page.url(), /#\/clip\/private\/01_01\?.*t=2/);
});

test('a view that makes no calls closes when the token is revoked', async (t) => {
  const page = await newPage(t, { expected: refused });
  const { name } = await storePrivate(t);
  await call(setup.secure, 'OperationService/WaitOperation', { name, timeout: '60s' });
  const reader = await createToken('ROLE_READER');
  await page.goto(`${setup.secure}/#/database/private`);
  await logIn(page, reader.secret);
  await page.getByText('Variance along').first().waitFor();
  await settled(page);
  await revokeToken(reader.name);
  await page.locator('input[name=token]').waitFor();
  await page.getByText(`Log in again: ${reader.name} was revoked.`).waitFor();
  assert.equal(await page.getByText('Variance along').count(), 0);
});
