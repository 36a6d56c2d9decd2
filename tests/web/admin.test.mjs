// The view of the server: status, operations, downloads, tokens and audit log, by role.
import assert from 'node:assert/strict';
import { stat } from 'node:fs/promises';
import { test } from 'node:test';
import { checkAccessibility, logIn, newPage } from './support/browser.mjs';
import { call, createToken, revokeToken } from './support/server.mjs';
import { setup } from './support/setup.mjs';

async function openAsAdmin(t, options) {
  const page = await newPage(t, options);
  await page.goto(`${setup.secure}/#/admin`);
  await logIn(page, setup.adminToken);
  return page;
}

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

test('a reader sees no tokens, no audit log and no backup', async (t) => {
  const reader = await createToken('ROLE_READER');
  const page = await newPage(t);
  await page.goto(`${setup.secure}/#/admin`);
  await logIn(page, reader.secret);
  await section(page, 'Status').locator('dd', { hasText: 'serving' }).waitFor();
  assert.equal(await page.getByRole('heading', { name: /Tokens|Audit log/ }).count(), 0);
  assert.equal(await page.getByRole('button', { name: /backup/ }).count(), 0);
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
    assert.ok((await stat(await download.path())).size > 100_000);
  }
});
