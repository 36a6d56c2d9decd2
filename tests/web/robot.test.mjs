// A robot with visual shapes: they are drawn where the server's poses place them.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { bipedUrdf, kChest } from './support/biped.mjs';
import { newPage, shown } from './support/browser.mjs';
import { colorsAt } from './support/pixels.mjs';
import { project } from './support/projection.mjs';
import { motiondb } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { stream } from './support/stream.mjs';

const kYaw = Math.PI / 6; // of the pelvis
const kPelvis = [0.2, -0.1, 0.8];

async function storeRobot() {
  const heading = [0, 0, Math.sin(kYaw / 2), Math.cos(kYaw / 2)];
  const angles = ['l_hip', 'l_knee', 'l_ankle', 'r_hip', 'r_knee', 'r_ankle'];
  const head = [
    'time_s',
    'root_x_m',
    'root_y_m',
    'root_z_m',
    'root_qx',
    'root_qy',
    'root_qz',
    'root_qw',
  ];
  // A still body would be no motion: the ankles move.
  const rows = Array.from({ length: 120 }, (_, frame) => [
    frame / 60,
    ...kPelvis,
    ...heading,
    0,
    0,
    0.2 * Math.sin(frame / 9),
    0,
    0,
    0.1,
  ]);
  const files = ['stand.csv', 'biped.urdf.gz'].map((name) => join(setup.folder, name));
  await writeFile(
    files[0],
    [[...head, ...angles], ...rows].map((row) => row.join(',')).join('\n') + '\n',
  );
  await writeFile(files[1], gzipSync(bipedUrdf({ arms: false })));
  await motiondb('create', 'robots', '--marker-set', 'source');
  await motiondb('ingest', 'robots', files[0], '--skeleton', files[1], '--label', 'stand');
}

// The position of the pelvis in a frame. The server moves motions to their floor.
async function pelvisAt(frame) {
  const [first] = await stream(setup.open, 'ViewService/ReadClipMotion', {
    name: 'databases/robots/clips/stand',
    firstFrame: frame,
    frameCount: 1,
    joints: true,
  });
  assert.equal(first.figure.jointNames[0], 'pelvis');
  const bytes = Buffer.from(first.jointPositions, 'base64');
  return [0, 4, 8].map((offset) => bytes.readFloatLE(offset));
}

// A point of the chest, from -1 to 1 along its axes, in the world.
function chestAt(pelvis, along) {
  const [x, y, z] = along.map((part, axis) => kChest.centre[axis] + (part * kChest.size[axis]) / 2);
  return [
    pelvis[0] + Math.cos(kYaw) * x - Math.sin(kYaw) * y,
    pelvis[1] + Math.sin(kYaw) * x + Math.cos(kYaw) * y,
    pelvis[2] + z,
  ];
}

test('the corners of a box are where the pose of its link places them', async (t) => {
  await storeRobot();
  const page = await newPage(t, { viewport: { width: 800, height: 600 }, deviceScaleFactor: 1 });
  const pelvis = await pelvisAt(30);
  const eye = [2, -1.7, 1.9];
  const target = [0.25, -0.05, 1.2];
  const camera = [...eye, ...target].join(',');
  await page.goto(
    `${setup.open}/#/clip/robots/stand?t=0.5&show=joints&camera=${camera}&statistics=1`,
  );
  await shown(page);
  await page.locator('.chart canvas').waitFor();
  await page.waitForFunction(() => document.querySelector('.statistics')?.dataset.calls > 0);
  const canvas = page.locator('.scene canvas');
  const box = await canvas.boundingBox();
  const at = (along) => project(chestAt(pelvis, along), eye, target, box.width, box.height);
  // From this side, two corners are behind the others: the outline has the six below.
  const outline = [
    [-1, -1, -1],
    [1, -1, -1],
    [1, 1, -1],
    [1, 1, 1],
    [-1, 1, 1],
    [-1, -1, 1],
  ];
  const middle = at([0, 0, 0]);
  const points = outline.flatMap((corner) => {
    const [x, y] = at(corner);
    const [dx, dy] = [x - middle[0], y - middle[1]];
    const length = Math.hypot(dx, dy);
    const beside = (pixels) => [x + (pixels * dx) / length, y + (pixels * dy) / length];
    return [beside(-5), beside(4)];
  });
  const colors = await colorsAt(page, canvas, points);
  const far = (a, b) => Math.max(...a.map((value, i) => Math.abs(value - b[i])));
  const background = (await colorsAt(page, canvas, [[5, 5]]))[0];
  for (let corner = 0; corner < outline.length; ++corner) {
    const text = `corner ${outline[corner]}: ${colors[2 * corner]}, ${colors[2 * corner + 1]}, background ${background}`;
    assert.ok(far(colors[2 * corner], background) > 20, `inside ${text}`);
    assert.ok(far(colors[2 * corner + 1], background) < 12, `outside ${text}`);
  }
  // The material of the box is red, that of nothing else.
  const [[red, green, blue]] = await colorsAt(page, canvas, [middle]);
  assert.ok(red > green + 40 && red > blue + 40, `middle of the box: ${red} ${green} ${blue}`);
  // Floor, joints, capsules of the thighs, boxes, cylinders, spheres.
  const calls = await page.evaluate(() => document.querySelector('.statistics').dataset.calls);
  assert.equal(calls, '6');
});
