// A planned motion plays on the figure, on a robot and on the floor, and is saved as files: with the
// numbers that the server plans.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { test } from 'node:test';
import { bipedUrdf } from './support/biped.mjs';
import { newPage } from './support/browser.mjs';
import { distance, placesOfInstances, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { readGlb } from './support/glb.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { floatsOf } from './support/stream.mjs';

// Poses on the floor of the page: x, y, heading.
const kStart = [0.5, -0.25, 0.5];
const kGoal = [1.5, 1, 1];
const kUrdf = Buffer.from(bipedUrdf({ arms: true }));

// The motions of the search that the page makes, in the frame of the start.
async function plannedMotions(body = {}) {
  const [dx, dy, turn] = kGoal.map((value, i) => value - kStart[i]);
  const [cos, sin] = [Math.cos(kStart[2]), Math.sin(kStart[2])];
  const response = await call(setup.open, 'QueryService/Plan', {
    database: 'databases/demo',
    clipStart: { clip: 'databases/demo/clips/01_01', seconds: 0.5 },
    goal: { xM: cos * dx + sin * dy, yM: cos * dy - sin * dx, headingRad: turn },
    alternativeCount: 1,
    seed: 7,
    ...body,
  });
  assert.equal(response.status, 200, JSON.stringify(response.body));
  return [response.body.motion, ...(response.body.alternatives ?? [])];
}
const place = `plan/demo?clip=01_01&time=0.5&start=${kStart}&goal=${kGoal}&alternatives=1&seed=7`;

const frameOf = (base64, size, frame) => floatsOf(base64).slice(size * frame, size * (frame + 1));
const markersOf = (motion, frame) =>
  frameOf(motion.markerPositions, 3 * motion.markerNames.length, frame);
const jointsOf = (motion, frame) =>
  frameOf(motion.jointPositions, 3 * motion.jointNames.length, frame);

// Fails if no draw call has its instances at these places.
function checkPlaces(drawn, expected, what) {
  const nearest = Math.min(...drawn.map((each) => distance(placesOfInstances(each), expected)));
  assert.ok(nearest < 1e-4, `${what}: ${nearest} m away`);
}

// The middle of each bone.
const middlesOf = (positions, bones) =>
  bones.flatMap(({ fromPoint = 0, toPoint = 0 }) =>
    [0, 1, 2].map((axis) => (positions[3 * fromPoint + axis] + positions[3 * toPoint + axis]) / 2),
  );

// A frame of a motion is what the scene and the floor show.
async function checkFrame(page, motion, frame) {
  const text = `frame ${frame}`;
  await page.locator('.position', { hasText: new RegExp(`${text}$`) }).waitFor();
  await whenDrawn(page, '.scene canvas', (drawn) => {
    const moving = drawn.filter(({ instances }) => instances > 0);
    checkPlaces(moving, markersOf(motion, frame), `markers of ${text}`);
    checkPlaces(moving, jointsOf(motion, frame), `joints of ${text}`);
  });
  await checkFloor(page, motion, frame);
}

// Start and goal give the scale of the floor: x is up, y is left.
async function checkFloor(page, motion, frame) {
  const circles = await page.locator('svg.floor').evaluate((svg) =>
    ['start', 'goal', 'body'].map((name) => {
      const circle = svg.querySelector(`.${name} circle`);
      const line = svg.querySelector(`.${name} line`);
      const at = (node, ...names) => names.map((each) => Number(node?.getAttribute(each) ?? NaN));
      return { at: at(circle, 'cx', 'cy'), tip: at(line, 'x2', 'y2') };
    }),
  );
  const [start, goal, body] = circles;
  const scale = (start.at[0] - goal.at[0]) / (kGoal[1] - kStart[1]);
  const { xM: x = 0, yM: y = 0, headingRad: heading = 0 } = motion.root[frame];
  const [cos, sin] = [Math.cos(kStart[2]), Math.sin(kStart[2])];
  const expected = [
    start.at[0] - scale * (sin * x + cos * y),
    start.at[1] - scale * (cos * x - sin * y),
  ];
  assert.ok(
    distance(body.at, expected) < 0.1,
    `body of frame ${frame} at ${body.at}, not ${expected}`,
  );
  const turned =
    Math.atan2(body.at[0] - body.tip[0], body.at[1] - body.tip[1]) - heading - kStart[2];
  assert.ok(Math.abs(Math.sin(turned / 2)) < 0.01, `heading of frame ${frame}`);
}

// Plays until other frames are shown; returns the frame at which it pauses.
async function playAndPause(page, from = 0) {
  // Keys wait for no picture of the screen.
  await page.getByRole('button', { name: 'Play' }).press('Enter');
  await page.waitForFunction((first) => {
    const [, frame] = document.querySelector('.position').textContent.match(/frame (\d+)$/);
    return Math.abs(Number(frame) - first) >= 10;
  }, from);
  await page.getByRole('button', { name: 'Pause' }).press('Enter');
  await page.getByRole('button', { name: 'Play' }).waitFor();
  const [, frame] = (await page.locator('.position').textContent()).match(/frame (\d+)$/);
  return Number(frame);
}

// Product of two unit quaternions x, y, z, w.
function times([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}
const rotate = (turn, [x, y, z]) =>
  times(
    times(turn, [x, y, z, 0]),
    turn.map((value, i) => (i < 3 ? -value : value)),
  ).slice(0, 3);

// The matrix of a shape of a link in a frame, column by column.
function matrixOf(motion, { joint = 0, sizeM, positionM, rotation }, frame) {
  const count = motion.jointNames.length;
  const origin = jointsOf(motion, frame).slice(3 * joint, 3 * joint + 3);
  const turn = frameOf(motion.jointRotations, 4 * count, frame).slice(4 * joint, 4 * joint + 4);
  const axes = [0, 1, 2].flatMap((axis) => {
    const along = [0, 1, 2].map((i) => (i === axis ? sizeM[axis] : 0));
    return [...rotate(times(turn, rotation), along), 0];
  });
  return [...axes, ...rotate(turn, positionM).map((value, i) => value + origin[i]), 1];
}

async function checkRobot(page, motion, frame) {
  await checkFrame(page, motion, frame);
  const kinds = new Set(motion.jointVisuals.map(({ geometry }) => geometry));
  assert.equal(kinds.size, 3);
  await whenDrawn(page, '.scene canvas', (drawn) => {
    for (const kind of kinds) {
      const visuals = motion.jointVisuals.filter(({ geometry }) => geometry === kind);
      const expected = visuals.flatMap((visual) => matrixOf(motion, visual, frame));
      const nearest = Math.min(...drawn.map(({ matrices }) => distance(matrices, expected)));
      assert.ok(nearest < 1e-4, `${kind} of frame ${frame}: ${nearest} away`);
    }
  });
}

// Position of one of `count` points in a frame of a list of positions.
const positionAt = (positions, count, frame, point) =>
  positions.slice(3 * (count * frame + point), 3 * (count * frame + point) + 3);

function checkTable(text, motion) {
  const [head, ...lines] = text.trimEnd().split('\n');
  const columns = motion.markerNames.flatMap((name) =>
    ['x', 'y', 'z'].map((axis) => `${name}_${axis}_m`),
  );
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

// The file that the server writes; its root moves like that of the motion.
function checkBvh(bytes, motion) {
  assert.deepEqual(bytes, Buffer.from(motion.file.data, 'base64'));
  const lines = bytes.toString().split('\n');
  const begin = lines.indexOf(`Frames: ${motion.frameCount}`);
  assert.ok(begin > 0, 'number of frames');
  assert.ok(
    Math.abs(Number(lines[begin + 1].split(':')[1]) * motion.frameRateHz - 1) < 1e-5,
    lines[begin + 1],
  );
  const joints = floatsOf(motion.jointPositions);
  for (let frame = 0; frame < motion.frameCount; ++frame) {
    // In cm; z is up in the plan, y in the file.
    const [x, y, z] = positionAt(joints, motion.jointNames.length, frame, 0);
    const root = lines[begin + 2 + frame].trim().split(/\s+/).slice(0, 3).map(Number);
    assert.ok(
      distance(root, [100 * x, 100 * z, -100 * y]) < 1e-3,
      `root of frame ${frame}: ${root}`,
    );
  }
}

const choose = (page, name) => page.getByRole('button', { name, exact: true }).press('Enter');
const showFrame = (page, frame) => page.getByLabel('Frame', { exact: true }).fill(String(frame));

async function checkPlaying(page, motions) {
  await checkFrame(page, motions[0], 0);
  await showFrame(page, 25);
  await checkFrame(page, motions[0], 25);
  await choose(page, 'Alternative 1');
  await checkFrame(page, motions[1], 0);
  const frame = await playAndPause(page);
  assert.ok(
    distance(markersOf(motions[1], frame), markersOf(motions[1], 0)) > 0.02,
    'the figure moves',
  );
  await checkFrame(page, motions[1], frame);
  // The bones join the markers.
  const { body } = await call(setup.open, 'ViewService/GetFigure', { name: 'databases/demo' });
  const middles = middlesOf(markersOf(motions[1], frame), body.figure.markerBones);
  await whenDrawn(page, '.scene canvas', (drawn) => checkPlaces(drawn, middles, 'bones'));
  await page.keyboard.press('End');
  await checkFrame(page, motions[1], motions[1].frameCount - 1);
}

async function checkFiles(page, motions) {
  const download = async (format) => {
    const [file] = await Promise.all([
      page.waitForEvent('download'),
      choose(page, `Download ${format}`),
    ]);
    return { name: file.suggestedFilename(), bytes: await readFile(await file.path()) };
  };
  const other = await download('CSV');
  assert.equal(other.name, 'plan-2.csv');
  checkTable(other.bytes.toString(), motions[1]);
  await choose(page, 'Best');
  const best = await download('CSV');
  assert.equal(best.name, 'plan.csv');
  checkTable(best.bytes.toString(), motions[0]);
  assert.notDeepEqual(other.bytes, best.bytes);
  const glb = await download('GLB');
  assert.equal(glb.name, 'plan.glb');
  checkAnimation(glb.bytes, motions[0]);
  const bvh = await download('BVH');
  assert.equal(bvh.name, 'plan.bvh');
  checkBvh(bvh.bytes, motions[0]);
}

async function checkOnRobot(page) {
  const robot = { fileName: 'biped.urdf', urdf: kUrdf.toString('base64') };
  const [motion] = await plannedMotions({ robot, alternativeCount: 0 });
  const file = { name: robot.fileName, mimeType: 'text/xml', buffer: kUrdf };
  await page.getByLabel('Robot (URDF)').setInputFiles(file);
  await page.getByLabel('Alternatives').fill('0');
  await choose(page, 'Plan');
  await checkRobot(page, motion, 0);
  // The frame in which a knee is bent most differently.
  const knees = ['l_knee', 'r_knee'].map((name) => motion.dofNames.indexOf(name));
  const angles = floatsOf(motion.jointAngles);
  const turnOf = (frame) =>
    Math.max(
      ...knees.map((dof) => Math.abs(angles[frame * motion.dofNames.length + dof] - angles[dof])),
    );
  const frames = Array.from({ length: motion.frameCount }, (_, frame) => frame);
  const bent = frames.reduce((best, frame) => (turnOf(frame) > turnOf(best) ? frame : best));
  assert.ok(turnOf(bent) > 0.2, `the knees turn by ${turnOf(bent)} rad`);
  await showFrame(page, bent);
  await checkRobot(page, motion, bent);
  await checkRobot(page, motion, await playAndPause(page, bent));
}

test('a plan plays as the server plans it, on figure, robot and floor, and is saved', async (t) => {
  const motions = await plannedMotions({ includeFiles: true, fileFormat: 'FILE_FORMAT_BVH' });
  const page = await newPage(t, { viewport: { width: 700, height: 500 } });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/${place}`);
  await t.test('figure and floor', () => checkPlaying(page, motions));
  await t.test('files', () => checkFiles(page, motions));
  await t.test('robot', () => checkOnRobot(page));
});
