// Files that nobody should upload: each gives its error beside it, and the store is unchanged.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { newPage, shown } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

async function clipNames() {
  const { body } = await call(setup.open, 'ClipService/ListClips', { parent: 'databases/demo' });
  return (body.clips ?? []).map((clip) => clip.name);
}

async function openClips(t) {
  const page = await newPage(t, { expected: [/status of 4\d\d/, /ERR_CONNECTION_RESET/] });
  await page.goto(`${setup.open}/#/clips/demo`);
  await shown(page);
  await page.locator('table.clips tbody tr').first().waitFor();
  return page;
}

const garbage = Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919 + (i >> 3)) & 255));

test('hostile files are refused one by one', async (t) => {
  const motion = await readFile(`${setup.models}/01_01.bvh`);
  const files = [
    ['garbage.bvh', garbage, /./],
    ['garbage.fbx', garbage, /./],
    ['garbage.gltf', garbage, /./],
    ['empty.bvh', Buffer.alloc(0), /empty/i],
    ['truncated.bvh', motion.subarray(0, motion.length * 0.6), /frame|value|line/i],
    ['bomb.bvh.gz', gzipSync(Buffer.alloc(300 << 20, ' '), { level: 1 }), /memory|256 MiB/],
    ['notes.docx', garbage, /docx|extension|format/i],
    [`${'x'.repeat(150)}<img src=x onerror="window.hacked=1">.bvh`, garbage, /./],
    ['<script>window.hacked=1</script>.bvh', Buffer.from(`HIERARCHY\nROOT ${setup.hostile}\n`), /./],
  ];
  const stored = await clipNames();
  const page = await openClips(t);
  await page.setInputFiles(
    'input[type=file]',
    files.map(([name, buffer]) => ({ name, mimeType: 'application/octet-stream', buffer })),
  );
  for (const [index, [name, , message]] of files.entries()) {
    const item = page.locator('.upload-item').nth(index);
    const error = item.locator('.notice.error p').first();
    await error.waitFor({ timeout: 60_000 });
    const text = await error.textContent();
    t.diagnostic(`${name.slice(0, 30)}: ${text.slice(0, 200)}`);
    assert.match(text, message, name);
    assert.ok(await item.getByRole('button', { name: 'Store', exact: true }).isDisabled());
  }
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator('main img, main script').count(), 0);
  assert.deepEqual(await clipNames(), stored);
});

test('a file that is larger than the server takes is refused with the limit', async (t) => {
  const stored = await clipNames();
  const page = await openClips(t);
  await page.evaluate(() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.items.add(new File([new Uint8Array(17 << 20)], 'huge.bvh'));
    document.body.dispatchEvent(new DragEvent('drop', { bubbles: true, dataTransfer }));
  });
  const error = page.locator('.upload-item .notice.error');
  await error.waitFor();
  assert.match(await error.textContent(), /max-message-mib/);
  await page.waitForTimeout(1200);
  assert.equal(await page.getByText('Connection lost').count(), 0);
  assert.deepEqual(await clipNames(), stored);
});
