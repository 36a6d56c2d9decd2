// What the page offers to each role of a token.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { disableWebGL, logIn, newPage } from './support/browser.mjs';
import { call, createToken } from './support/server.mjs';
import { setup } from './support/setup.mjs';

const clip = 'databases/roles/clips/01_01';

async function storeClip(t) {
  await call(setup.secure, 'DatabaseService/CreateDatabase', { databaseId: 'roles' });
  t.after(() => call(setup.secure, 'DatabaseService/DeleteDatabase', { name: 'databases/roles' }));
  const file = (await readFile(`${setup.models}/01_01.bvh`)).toString('base64');
  const header = { parent: 'databases/roles', fileName: '01_01.bvh' };
  const { status } = await call(setup.secure, 'ClipService/UploadClip', { header, file });
  assert.equal(status, 200);
}

// The controls of three views, after something that all roles see.
const views = [
  [
    'admin',
    (page) => page.locator('section[aria-label=Status] dd', { hasText: 'serving' }),
    {
      exported: (page) => page.getByRole('button', { name: 'Download database' }),
      backup: (page) => page.getByRole('button', { name: /backup/ }),
      tokens: (page) => page.getByRole('heading', { name: 'Tokens' }),
      audit: (page) => page.getByRole('heading', { name: 'Audit log' }),
    },
  ],
  [
    'clip/roles/01_01',
    (page) => page.locator('.segment-body').first(),
    {
      edit: (page) => page.getByRole('button', { name: 'Edit', exact: true }),
      segment: (page) => page.getByRole('button', { name: 'Add segment from here' }),
      undo: (page) => page.getByRole('button', { name: 'Undo last edit' }),
    },
  ],
  [
    'clips/roles',
    (page) => page.getByRole('link', { name: '01_01' }),
    {
      upload: (page) => page.getByRole('region', { name: 'Upload' }),
      remove: (page) => page.getByRole('button', { name: 'Delete 01_01' }),
    },
  ],
];

const controls = {
  READER: ['exported'],
  INGESTER: ['exported', 'edit', 'segment', 'undo', 'upload', 'remove'],
  ADMIN: ['exported', 'backup', 'tokens', 'audit', 'edit', 'segment', 'undo', 'upload', 'remove'],
};

test('each role sees its controls, and an ingester deletes a clip', async (t) => {
  const page = await newPage(t);
  await storeClip(t);
  await disableWebGL(page);
  await page.goto(`${setup.secure}/#/admin`);
  for (const role of ['READER', 'ADMIN', 'INGESTER']) {
    await logIn(page, (await createToken(`ROLE_${role}`)).secret);
    const seen = [];
    for (const [place, opened, candidates] of views) {
      await page.goto(`${setup.secure}/#/${place}`);
      await opened(page).waitFor();
      // The properties of a clip are closed.
      await page
        .locator('details')
        .evaluateAll((all) => all.forEach((details) => (details.open = true)));
      for (const [name, control] of Object.entries(candidates)) {
        if (await control(page).isVisible()) seen.push(name);
      }
    }
    assert.deepEqual(seen, controls[role], role);
    if (role !== 'INGESTER') await page.getByRole('button', { name: 'Log out' }).click();
  }
  await page.getByRole('button', { name: 'Delete 01_01' }).click();
  await page.getByRole('button', { name: /Really delete/ }).click();
  await page.getByRole('link', { name: '01_01' }).waitFor({ state: 'detached' });
  assert.equal((await call(setup.secure, 'ClipService/GetClip', { name: clip })).status, 404);
});

test('a token of one database sees no sections about the server', async (t) => {
  const page = await newPage(t);
  await storeClip(t);
  await page.goto(`${setup.secure}/#/admin`);
  await logIn(page, (await createToken('ROLE_INGESTER', 'databases/roles')).secret);
  await page
    .getByRole('region', { name: 'Operations', exact: true })
    .getByText('roles')
    .first()
    .waitFor();
  const sections = await page
    .locator('main section')
    .evaluateAll((all) => all.map((each) => each.ariaLabel));
  assert.deepEqual(sections, ['Operations', 'Downloads']);
  const downloads = page.getByRole('region', { name: 'Downloads', exact: true });
  await downloads.locator('option').waitFor({ state: 'attached' });
  assert.deepEqual(await downloads.locator('option').allTextContents(), ['roles']);
  assert.equal(await page.locator('.notice.error:visible').count(), 0);
});
