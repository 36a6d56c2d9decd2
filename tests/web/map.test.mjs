// The map of states as WebGL draws it: Figs. 6 to 10 of the paper, against the numbers of the server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage } from './support/browser.mjs';
import { recordDrawing, whenDrawn } from './support/drawing.mjs';
import { setup } from './support/setup.mjs';
import { clearNodes, placesOf, readMap } from './support/state_map.mjs';
import { fingersOf, tapOf } from './support/touch.mjs';

const vector = (values, i) => values.slice(3 * i, 3 * i + 3);
const columns = (matrices, i) =>
  [0, 1, 2, 3].map((k) => matrices.slice(16 * i + 4 * k, 16 * i + 4 * k + 3));
const length = (a) => Math.hypot(...a);
const scaled = (a, factor) => a.map((value) => value * factor);
const apart = (a, b) => length(a.map((value, k) => value - b[k]));

function assertNear(a, b, tolerance, text) {
  assert.ok(apart(a, b) <= tolerance, `${text}: ${a} instead of ${b}`);
}

// The parts of a picture of the map; `nodes` and `edges` are the numbers of instances.
function partsOf(drawn, nodes, edges) {
  const meshes = drawn.filter(({ kind, instances }) => kind === 'triangles' && instances > 0);
  assert.deepEqual(
    meshes.map(({ instances }) => instances).sort(),
    [nodes, edges].filter(Boolean).sort(),
  );
  // Ellipsoids have colours of their own, edges have one for all.
  return {
    ellipsoids: meshes.find(({ instanceColors }) => instanceColors.length > 0),
    edges: meshes.find(({ instanceColors }) => instanceColors.length === 0),
  };
}

// Waits until the picture has an ellipsoid for each node of the map that `isShown` accepts and an edge
// for each transition between two of them with at least the probability `least`. `size`: of the
// ellipsoids in standard deviations.
function checkMap(page, map, { isShown = () => true, least = 0, size = 0.5 } = {}) {
  const shown = map.ids.flatMap((_, node) => (isShown(node) ? [node] : []));
  const nodeOf = new Map(shown.map((node) => [map.ids[node], node]));
  const edges = map.transitions.filter(
    ([from, to, probability]) =>
      from !== to && nodeOf.has(from) && nodeOf.has(to) && probability >= least,
  );
  return whenDrawn(page, '.map canvas', (drawn) => {
    const parts = partsOf(drawn, shown.length, edges.length);
    shown.forEach((node, place) => {
      const [first, second, third, at] = columns(parts.ellipsoids.matrices, place);
      assertNear(at, vector(map.means, node), 1e-5, `mean of node ${map.ids[node]}`);
      const axes = [0, 1, 2].map((k) => scaled(vector(map.semiAxes, 3 * node + k), size));
      // A flat ellipsoid gets a least thickness.
      assertNear(first, axes[0], 2e-3, `first axis of node ${map.ids[node]}`);
      assertNear(second, axes[1], 2e-3, `second axis of node ${map.ids[node]}`);
      const sign = third.reduce((sum, value, k) => sum + value * axes[2][k], 0) < 0 ? -1 : 1;
      assertNear(third, scaled(axes[2], sign), 2e-3, `third axis of node ${map.ids[node]}`);
    });
    const widths = edges.map(([from, to, probability], place) => {
      const [across, along, , middle] = columns(parts.edges.matrices, place);
      const ends = [from, to].map((id) => vector(map.means, nodeOf.get(id)));
      assertNear(
        middle,
        ends[0].map((value, k) => (value + ends[1][k]) / 2),
        1e-5,
        `edge ${from}-${to}`,
      );
      assertNear(
        along,
        ends[1].map((value, k) => value - ends[0][k]),
        1e-4,
        `edge ${from}-${to}`,
      );
      return { probability, width: length(across) };
    });
    widths.sort((a, b) => a.probability - b.probability);
    for (const [i, { probability, width }] of widths.slice(1).entries()) {
      const before = widths[i];
      assert.ok(
        width >= before.width * 0.9999,
        `${probability} is not thinner than ${before.probability}`,
      );
      if (probability > before.probability + 0.01) assert.ok(width > before.width);
    }
    if (edges.length > 1 && widths.at(-1).probability > 4 * widths[0].probability)
      assert.ok(widths.at(-1).width > 1.2 * widths[0].width, 'probable transitions are wider');
  });
}

// Position and target of the camera in the URL.
async function cameraOf(page) {
  await page.waitForURL(/camera=/);
  const values = new URL(page.url().replace('#/', '')).searchParams
    .get('camera')
    .split(',')
    .map(Number);
  return {
    eye: values.slice(0, 3),
    target: values.slice(3),
    distance: apart(values.slice(0, 3), values.slice(3)),
  };
}

// The camera after a gesture.
async function moved(page, gesture) {
  const { hash } = new URL(page.url());
  await gesture();
  // The page writes a gesture in parts.
  for (let last = hash; last === hash || last !== new URL(page.url()).hash;) {
    last = new URL(page.url()).hash;
    await page.waitForTimeout(500);
  }
  return cameraOf(page);
}

async function open(t, query, options = {}) {
  const page = await newPage(t, { viewport: { width: 700, height: 600 }, ...options });
  await recordDrawing(page);
  await page.goto(`${setup.open}/#/database/demo${query}`);
  await page.locator('.map-controls output', { hasText: 'Layer' }).waitFor();
  return page;
}

const control = (page, name) => page.locator('.map-controls').getByLabel(name);
const set = (input, value) =>
  input.evaluate((node, text) => {
    node.value = text;
    node.dispatchEvent(new Event('change'));
  }, value);

// Planes of two axes, and zoom with the wheel.
async function checkPlanes(page, map) {
  const canvas = page.locator('.map canvas');
  const checkCamera = async (eye, degrees) => {
    const { x, y, width, height } = await canvas.boundingBox(); // the page scrolls to what is used
    const places = placesOf(map, eye, width, height, degrees);
    const inside = (node) =>
      Math.abs(places[node].x / width - 0.5) < 0.45 &&
      Math.abs(places[node].y / height - 0.5) < 0.45;
    for (const node of clearNodes(places, places.length).filter(inside).slice(0, 2)) {
      await page.mouse.move(x + places[node].x, y + places[node].y);
      await page
        .locator('.node-panel', { hasText: `Node ${map.ids[node]} of layer ${map.header.layer}:` })
        .waitFor();
    }
  };
  const { width, height } = await canvas.boundingBox();
  const reach = 3 / Math.sin((2 * Math.PI) / 180) / Math.min(1, width / height);
  for (const [axes, from] of [
    ['12', [0, -1e-6, 1]],
    ['13', [0, -1, 0]],
    ['23', [1, 0, 0]],
  ]) {
    await control(page, 'Axes').selectOption(axes);
    await checkCamera(scaled(from, reach), 4);
  }
  await control(page, 'Axes').selectOption('123');
  await canvas.press('+');
  const before = await cameraOf(page);
  await canvas.hover();
  const scroll = await page.evaluate(() => scrollY);
  const after = await moved(page, () => page.mouse.wheel(0, -240));
  assert.ok(
    after.distance < 0.95 * before.distance,
    `${before.distance} m, then ${after.distance} m`,
  );
  assertNear(
    scaled(after.eye, 1 / after.distance),
    scaled(before.eye, 1 / before.distance),
    0.01,
    'direction',
  );
  await checkCamera(after.eye, 40);
  const back = await moved(page, () => page.mouse.wheel(0, 240));
  assert.ok(back.distance > 1.05 * after.distance);
  assert.equal(await page.evaluate(() => scrollY), scroll);
}

test('nodes and transitions of the map are those of the server, in each plane', async (t) => {
  const layer = 6;
  const page = await open(t, `?layer=${layer - 1}&points=0`);
  // Fig. 9: the global graph; keys and slider change the layer.
  await page.locator('.map canvas').press(']');
  await page.locator('output', { hasText: `Layer ${layer} of` }).waitFor();
  const map = await readMap('demo', layer, 0);
  assert.ok(map.ids.length > 20, `${map.ids.length} nodes`);
  await checkMap(page, map);
  await page.waitForURL(new RegExp(`layer=${layer}\\b`));
  await page.getByRole('slider', { name: 'Layer' }).press('ArrowLeft');
  const above = await readMap('demo', layer - 1, 0);
  await checkMap(page, above);
  await checkPlanes(page, above);
  await page.getByRole('slider', { name: 'Layer' }).press('ArrowRight');

  await set(control(page, 'Ellipsoids, standard deviations'), '1');
  await checkMap(page, map, { size: 1 });
  await set(control(page, 'Transitions from probability'), '0.2');
  const few = map.transitions.filter(
    ([from, to, probability]) => from !== to && probability >= 0.2,
  );
  assert.ok(few.length > 0 && few.length < map.transitions.length / 2);
  await checkMap(page, map, { size: 1, least: 0.2 });
  await page.waitForURL(/least=0\.2/);
  await set(control(page, 'Transitions from probability'), '0');

  // A label that is hidden has no nodes and edges, until it is shown again.
  const button = page.getByRole('group', { name: 'Legend' }).getByRole('button', { name: 'climb' });
  await button.click();
  const isShown = (node) => map.header.labels[map.mainClips[node]] !== 'climb';
  await checkMap(page, map, { size: 1, isShown });
  assert.equal(await button.getAttribute('aria-pressed'), 'false');
  await page.waitForURL(/hide=climb/);
  await button.click();
  await checkMap(page, map, { size: 1 });

  // Fig. 10: the graph of one clip.
  await set(control(page, 'Graph of clip'), '01_01');
  const clip = await readMap('demo', layer, 0, '01_01');
  assert.ok(clip.ids.length < map.ids.length);
  await checkMap(page, clip, { size: 1 });
});

test('fingers choose a node, turn and zoom the map', async (t) => {
  const eye = [2, -7, 4];
  const page = await open(t, `?layer=4&camera=${eye.join(',')},0,0,0`, { hasTouch: true });
  const map = await readMap('demo', 4, 20000);
  const { x, y, width, height } = await page.locator('.map canvas').boundingBox();
  const places = placesOf(map, eye, width, height);
  const [node] = clearNodes(places, 1);
  const tapAt = await tapOf(page);
  await tapAt(x + places[node].x, y + places[node].y);
  await page.locator('.node-panel', { hasText: `Node ${map.ids[node]} of layer 4:` }).waitFor();
  await page.waitForURL(new RegExp(`node=${map.ids[node]}\\b`));

  const touch = await fingersOf(page);
  const middle = [x + width / 2, y + height / 2];
  const turned = await moved(page, () =>
    touch([0, 20, 40, 60].map((step) => [[middle[0] + step, middle[1]]])),
  );
  assert.ok(Math.abs(turned.distance - length(eye)) < 0.02, 'one finger does not zoom');
  // To the right: the camera goes to the left around the vertical axis, 2 pi for the height.
  const angle = Math.atan2(turned.eye[1], turned.eye[0]) - Math.atan2(eye[1], eye[0]);
  assert.ok(Math.abs(angle + (2 * Math.PI * 60) / height) < 0.15, `${angle} rad`);
  assert.ok(Math.abs(turned.eye[2] - eye[2]) < 0.1);
  assert.deepEqual(turned.target, [0, 0, 0]);

  const fingers = (half) => [
    [middle[0] - half, middle[1]],
    [middle[0] + half, middle[1]],
  ];
  const near = await moved(page, () => touch([50, 60, 80, 100].map(fingers)));
  assert.ok(
    Math.abs(near.distance / turned.distance - 0.5) < 0.1,
    `${near.distance} of ${turned.distance}`,
  );
  assertNear(
    scaled(near.eye, 1 / near.distance),
    scaled(turned.eye, 1 / turned.distance),
    0.05,
    'direction',
  );
});
