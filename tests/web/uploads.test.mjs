// Files that nobody should upload: each gives its error beside it, and the store is unchanged.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { bipedUrdf } from './support/biped.mjs';
import { newPage, shown } from './support/browser.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';

async function clipNames() {
  const { body } = await call(setup.open, 'ClipService/ListClips', { parent: 'databases/demo' });
  return (body.clips ?? []).map((clip) => clip.name);
}

async function open(t, place) {
  const page = await newPage(t, { expected: [/status of 4\d\d/, /ERR_CONNECTION_RESET/] });
  await page.goto(`${setup.open}/#/${place}`);
  await shown(page);
  return page;
}

async function openClips(t) {
  const page = await open(t, 'clips/demo');
  await page.locator('table.clips tbody tr').first().waitFor();
  return page;
}

const garbage = Buffer.from(Array.from({ length: 5000 }, (_, i) => (i * 7919 + (i >> 3)) & 255));
const bomb = gzipSync(Buffer.alloc(300 << 20, ' '), { level: 1 });

// Names and bytes of files, with what the error says.
async function hostileMotions() {
  const motion = await readFile(`${setup.models}/01_01.bvh`);
  return [
    ['garbage.bvh', garbage, /^garbage\.bvh:1: expected 'HIERARCHY', found /],
    ['garbage.fbx', garbage, /^garbage\.fbx: FBX-Parser /],
    ['garbage.gltf', garbage, /^garbage\.gltf: invalid JSON at byte 0 /],
    ['empty.bvh', Buffer.alloc(0), /: the file is empty$|^empty\.bvh:1: the file ends here /],
    [
      'truncated.bvh',
      motion.subarray(0, motion.length * 0.6),
      /^truncated\.bvh:\d+: the file ends here .*, expected number \d+ of \d+ of frame \d+ of \d+$/,
    ],
    ['bomb.bvh.gz', bomb, /memory|256 MiB/],
    ['notes.docx', garbage, /^notes\.docx: expected a motion file \(\.bvh, /],
    [
      `${'x'.repeat(150)}<img src=x onerror="window.hacked=1">.bvh`,
      garbage,
      /^x{150}<img src=x onerror="window\.hacked=1">\.bvh:1: expected 'HIERARCHY', found /,
    ],
    [
      '<script>window.hacked=1</script>.bvh',
      Buffer.from(`HIERARCHY\nROOT ${setup.hostile}\n`),
      // Without the part before the slash, which is a folder for the server.
      /script>\.bvh:3: the file ends here .*, expected '\{' after joint '<img src=x onerror=/,
    ],
  ];
}

// The same for robots.
function hostileRobots() {
  const robot = bipedUrdf({ arms: true });
  const entities = Array.from({ length: 30 }, (_, i) => `<!ENTITY e${i + 1} "&e${i};&e${i};">`);
  const laughs = `<?xml version="1.0"?><!DOCTYPE robot [<!ENTITY e0 "ha">${entities.join('')}]>`;
  const hostile = setup.hostileMarker.replaceAll('<', '&lt;');
  return [
    ['garbage.urdf', garbage, /^garbage\.urdf:1: expected text in UTF-8, found a zero byte$/],
    ['empty.urdf', Buffer.alloc(0), /^empty\.urdf:1: expected well-formed XML, found /],
    [
      'truncated.urdf',
      Buffer.from(robot.slice(0, robot.length / 2)),
      /^truncated\.urdf:1: expected well-formed XML, found /,
    ],
    [
      'laughs.urdf',
      Buffer.from(`${laughs}<robot name="a"><link name="&e30;"/></robot>`),
      /^laughs\.urdf:1: expected no document type$/,
    ],
    ['bomb.urdf.gz', bomb, /memory|256 MiB/],
    [
      '<img src=x onerror="window.hacked=1">.urdf',
      Buffer.from(`<robot name="a"><link name="${hostile}"/></robot>`),
      /^no mapping of marker set 'standard34' fits, and the 1 joints \('<img\/src='x'onerror=/,
    ],
  ];
}

const fileOf = ([name, buffer]) => ({ name, mimeType: 'application/octet-stream', buffer });

// The page has taken no text of a file as HTML, and nothing is stored.
async function checkUnchanged(page, stored) {
  assert.equal(await page.evaluate(() => window.hacked), undefined);
  assert.equal(await page.locator('main img, main script').count(), 0);
  assert.deepEqual(await clipNames(), stored);
}

function checkError(t, text, [name, , message]) {
  t.diagnostic(`${name.slice(0, 30)}: ${text.slice(0, 200)}`);
  assert.match(text, message, name);
}

test('hostile files are refused one by one', async (t) => {
  const files = await hostileMotions();
  const stored = await clipNames();
  const page = await openClips(t);
  await page.setInputFiles('input[type=file]', files.map(fileOf));
  for (const [index, file] of files.entries()) {
    const item = page.locator('.upload-item').nth(index);
    const error = item.locator('.notice.error p').first();
    await error.waitFor({ timeout: 60_000 });
    checkError(t, await error.textContent(), file);
    assert.ok(await item.getByRole('button', { name: 'Store', exact: true }).isDisabled());
  }
  await checkUnchanged(page, stored);
});

// Chooses each file and asks about it; its error appears at the form.
async function askWithEach(t, page, button, files) {
  const stored = await clipNames();
  for (const file of files) {
    await page.setInputFiles('form input[type=file]', fileOf(file));
    await page.getByRole('button', { name: button, exact: true }).click();
    const error = page.locator('main .notice.error p').first();
    await error.waitFor({ timeout: 60_000 });
    checkError(t, await error.textContent(), file);
  }
  await checkUnchanged(page, stored);
}

test('a query with a hostile file shows its error', async (t) => {
  const page = await open(t, 'query/demo');
  await askWithEach(t, page, 'Ask', await hostileMotions());
  assert.ok(await page.locator('.player').isHidden());
});

test('a plan with a hostile robot shows its error', async (t) => {
  const page = await open(t, 'plan/demo');
  await page.locator('svg.floor .goal').waitFor();
  await askWithEach(t, page, 'Plan', hostileRobots());
});

// Drops a file of so many MiB. Its parts are the same bytes, so that it needs no memory of its size.
const dropMebibytes = (page, mebibytes) =>
  page.evaluate((size) => {
    const dataTransfer = new DataTransfer();
    const part = new Blob([new Uint8Array(1 << 20)]);
    dataTransfer.items.add(new File(Array(size).fill(part), 'huge.bvh'));
    document.body.dispatchEvent(new DragEvent('drop', { bubbles: true, dataTransfer }));
  }, mebibytes);

test('a file that is larger than the server takes is refused with the limit', async (t) => {
  const stored = await clipNames();
  const page = await openClips(t);
  await page.evaluate(() => {
    window.lost = false;
    new MutationObserver(() => {
      window.lost ||= document.body.textContent.includes('Connection lost');
    }).observe(document.body, { childList: true, subtree: true });
  });
  await dropMebibytes(page, 17);
  const error = page.locator('.upload-item .notice.error');
  await error.waitFor();
  assert.match(await error.textContent(), /max-message-mib/);
  // The page asks every few seconds whether the server answers.
  await page.waitForResponse(/\/session$/);
  assert.equal(await page.evaluate(() => window.lost), false);
  assert.deepEqual(await clipNames(), stored);
});

test('a file that is larger than any request is refused without being read', async (t) => {
  const page = await openClips(t);
  const calls = [];
  page.on('request', (request) => calls.push(request.url()));
  await dropMebibytes(page, 1100);
  const error = page.locator('.upload-item .notice.error p');
  await error.waitFor();
  assert.match(await error.textContent(), /^huge\.bvh: expected at most 1,024 MiB.*got 1,100 MiB/);
  assert.ok(!calls.some((url) => url.includes('UploadClip')), calls.join());
});
