// The files of a plan: CSV and GLB have the motion that the server plans.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { newPage } from './support/browser.mjs';
import { distance } from './support/drawing.mjs';
import { readGlb } from './support/glb.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf } from './support/stream.mjs';

// The motions of the search that the page of `place` makes, best first.
async function plannedMotions() {
  const { status, body } = await call(setup.open, 'QueryService/Plan', {
    database: 'databases/demo',
    clipStart: { clip: 'databases/demo/clips/01_01', seconds: 0.5 },
    goal: { xM: 1.5, yM: 0.5, headingRad: 0.5 },
    alternativeCount: 1,
    seed: 7,
  });
  assert.equal(status, 200, JSON.stringify(body));
  return [body.motion, ...body.alternatives];
}
const place = 'plan/demo?clip=01_01&time=0.5&goal=1.5,0.5,0.5&alternatives=1&seed=7';

// Position of one of `count` points in a frame of a list of positions.
const positionAt = (positions, count, frame, point) =>
  positions.slice(3 * (count * frame + point), 3 * (count * frame + point) + 3);

function checkTable(text, motion) {
  const [head, ...lines] = text.trimEnd().split('\n');
  const columns = motion.markerNames.flatMap((name) => ['x', 'y', 'z'].map((axis) => `${name}_${axis}_m`));
  assert.equal(head, ['time_s', ...columns].join(','));
  assert.equal(lines.length, motion.frameCount);
  const positions = floatsOf(motion.markerPositions);
  lines.forEach((line, frame) => {
    const [time, ...values] = line.split(',').map(Number);
    assert.ok(Math.abs(time - frame / motion.frameRateHz) < 1e-9, `time of frame ${frame}`);
    const expected = positions.slice(columns.length * frame, columns.length * (frame + 1));
    assert.ok(distance(values, expected) < 1e-6, `frame ${frame}`);
  });
}

function checkAnimation(bytes, motion) {
  const { json, animations } = readGlb(bytes);
  assert.equal(animations.length, 1);
  const nodes = json.nodes.map(({ name }) => name);
  assert.deepEqual(nodes.slice(0, motion.jointNames.length), motion.jointNames);
  const [root] = animations[0].filter(({ node, path }) => node === 0 && path === 'translation');
  assert.equal(root.values.length, motion.frameCount);
  const joints = floatsOf(motion.jointPositions);
  root.values.forEach((value, frame) => {
    assert.ok(Math.abs(root.times[frame] - frame / motion.frameRateHz) < 1e-4);
    // z is up in the plan, y in the file.
    const [x, y, z] = positionAt(joints, motion.jointNames.length, frame, 0);
    assert.ok(distance(value, [x, z, -y]) < 1e-4, `root of frame ${frame}: ${value}, ${[x, y, z]}`);
    // The root is near the reference frame of the plan, which is below the hips.
    const { xM = 0, yM = 0 } = motion.root[frame];
    assert.ok(Math.hypot(x - xM, y - yM) < 0.3, `frame ${frame} is at ${[xM, yM]}`);
  });
  assert.ok(animations[0].filter(({ path }) => path === 'rotation').length > 10, 'joints turn');
}

test('CSV and GLB of a plan have the frames of the chosen motion', async (t) => {
  const motions = await plannedMotions();
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await page.goto(`${setup.open}/#/${place}`);
  const rows = page.locator('section[aria-label="Planned motions"] tbody tr');
  await rows.nth(motions.length - 1).waitFor();
  const download = async (format) => {
    const [file] = await Promise.all([
      page.waitForEvent('download'),
      page.getByRole('button', { name: `Download ${format}` }).click(),
    ]);
    return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
  };
  const glb = await download('GLB');
  assert.equal(glb.name, 'plan.glb');
  checkAnimation(glb.bytes, motions[0]);
  const best = await download('CSV');
  assert.equal(best.name, 'plan.csv');
  checkTable(best.bytes.toString(), motions[0]);
  await page.getByRole('button', { name: 'Alternative 1' }).click();
  const other = await download('CSV');
  assert.equal(other.name, 'plan-2.csv');
  checkTable(other.bytes.toString(), motions[1]);
  assert.notDeepEqual(other.bytes, best.bytes);
});
