// The view of a database: map of states, layers, Table I.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown } from './support/browser.mjs';
import { distance, recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { clearNodes, placesOf, readMap } from './support/state_map.mjs';
import { floatsOf } from './support/stream.mjs';

async function open(t, query = '', options = {}, prepare = undefined) {
  const page = await newPage(t, options);
  await prepare?.(page);
  await page.goto(`${setup.open}/#/database/demo${query}`);
  await shown(page);
  await page.locator('.map-controls output', { hasText: 'Layer' }).waitFor();
  return page;
}

// Places of the markers of a mean pose in its picture, px.
async function posePlaces(layer, node) {
  const request = { parent: 'databases/demo/models/current', layer, nodeIds: [node] };
  const { body } = await call(setup.open, 'ViewService/GetNodePoses', request);
  const values = floatsOf(body.poses[0].markerPositions);
  const [width, height, turn] = [200, 220, 0.6];
  const scale = (0.86 * height) / Math.max(...values.filter((_, i) => i % 3 === 2));
  return Array.from({ length: values.length / 3 }, (_, marker) => {
    const [x, y, z] = values.slice(3 * marker, 3 * marker + 3);
    const across = Math.sin(turn) * x + Math.cos(turn) * y;
    return [width / 2 + scale * across, 0.94 * height - scale * z];
  });
}

test('a node is where the camera projects the mean that the server sends', async (t) => {
  const eye = [2, -7, 4];
  const page = await open(t, `?layer=5&camera=${eye.join(',')},0,0,0`);
  const map = await readMap('demo', 5, 20000);
  const box = await page.locator('.map canvas').boundingBox();
  const places = placesOf(map, eye, box.width, box.height);
  for (const node of clearNodes(places, 4)) {
    await page.mouse.move(box.x + places[node].x, box.y + places[node].y);
    const text = `Node ${map.ids[node]} of layer 5:`;
    await page.locator('.node-panel', { hasText: text }).waitFor();
  }
  // The mean pose of the last one.
  const [node] = clearNodes(places, 4).slice(-1);
  const picture = page.getByRole('img', {
    name: `Mean pose of node ${map.ids[node]}`,
    exact: true,
  });
  await picture.waitFor();
  const drawn = await picture
    .locator('.marker')
    .evaluateAll((markers) =>
      markers.map((each) => [each.cx.baseVal.value, each.cy.baseVal.value]),
    );
  const expected = await posePlaces(5, map.ids[node]);
  assert.ok(expected.length > 20);
  assert.ok(distance(drawn.flat(), expected.flat()) < 0.01, `${drawn} instead of ${expected}`);
  const { viewBox } = await picture.evaluate(({ viewBox: { baseVal: box } }) => ({
    viewBox: [box.width, box.height],
  }));
  assert.deepEqual(viewBox, [200, 220]);
});

test('the address has what was changed just before a link', async (t) => {
  const page = await open(t, '?layer=4');
  // The second change is written with a delay.
  await page.evaluate(() => {
    for (let i = 0; i < 2; ++i)
      document
        .querySelector('.map canvas')
        .dispatchEvent(new KeyboardEvent('keydown', { key: '[', bubbles: true }));
    [...document.querySelectorAll('nav a')].find((link) => link.textContent === 'Clips').click();
  });
  await page.waitForURL(/#\/clips\/demo/);
  await page.goBack();
  await page.waitForURL(/#\/database\/demo\?layer=2/);
  await page.locator('.map-controls output', { hasText: 'Layer 2' }).waitFor();
});

test('Shift with arrow keys moves the map', async (t) => {
  const page = await open(t, '?layer=4&camera=0,-7,0,0,0,0');
  await page.locator('.map canvas').press('Shift+ArrowRight');
  await page.waitForURL(/camera=0\.35%2C-7\.00%2C-?0\.00%2C0\.35%2C-?0\.00%2C-?0\.00/);
  await page.locator('.map canvas').press('Shift+ArrowUp');
  await page.waitForURL(/camera=0\.35%2C-7\.00%2C0\.35%2C0\.35%2C-?0\.00%2C0\.35/);
});

test('Table I has the statistics of the server', async (t) => {
  const page = await open(t);
  const { body } = await call(setup.open, 'DatabaseService/GetDatabase', {
    name: 'databases/demo',
    view: 'DATABASE_VIEW_FULL',
  });
  const { statistics } = body.database;
  const table = page.getByRole('table', { name: 'Properties of the database' });
  await table.waitFor();
  const number = (value = 0) => value.toLocaleString('en-GB');
  const rows = await table
    .locator('tr')
    .evaluateAll((all) => all.map(({ cells }) => [...cells].map((cell) => cell.textContent)));
  assert.deepEqual(rows, [
    ['Frames', number(statistics.frameCount)],
    ['Clips', number(statistics.clipCount)],
    ['Stored clips', number(statistics.storedClipCount)],
    ['Layers', number(statistics.layerCount)],
    ['Nodes', number(statistics.nodeCount)],
    ['Nodes in the bottom layer', number(statistics.bottomNodeCount)],
    ['Dimensions of a state', number(statistics.dimensionCount)],
    ['Frame rate', `${statistics.frameRateHz} Hz`],
    ['Build time', `${statistics.buildSeconds.toFixed(2)} s`],
    ['Model version', number(statistics.modelVersion)],
    ['Clips added since the build', number(statistics.addedClipCount)],
    ['Drift', `${Math.round(100 * (statistics.driftFraction ?? 0))} %`],
  ]);
});

test('the table of layers has their nodes, and opens a layer', async (t) => {
  const page = await open(t, '?layer=5');
  const { body } = await call(setup.open, 'DatabaseService/GetDatabase', {
    name: 'databases/demo',
    view: 'DATABASE_VIEW_FULL',
  });
  const table = page.getByRole('table', { name: 'Nodes of each layer' });
  await table.waitFor();
  const rows = await table
    .locator('tbody tr')
    .evaluateAll((all) => all.map(({ cells }) => [...cells].map((cell) => cell.textContent)));
  const { nodesPerLayer } = body.database.statistics;
  assert.deepEqual(
    rows,
    nodesPerLayer.map((nodes, i) => [`Layer ${i + 1}`, nodes.toLocaleString('en-GB')]),
  );
  const pressed = table.locator('button[aria-pressed=true]');
  assert.deepEqual(await pressed.allTextContents(), ['Layer 5']);
  await table.getByRole('button', { name: 'Layer 3', exact: true }).click();
  await page.waitForURL(/layer=3/);
  await page.locator('.map-controls output', { hasText: /^Layer 3/ }).waitFor();
  assert.deepEqual(await pressed.allTextContents(), ['Layer 3']);
});

test('without WebGL a flat map and the tables work', async (t) => {
  const page = await newPage(t);
  await disableWebGL(page);
  await page.goto(`${setup.open}/#/database/demo?layer=4&axes=12`);
  await page.locator('.flat-map canvas').waitFor();
  // Drag and keys move the map: the node is where the pointer left it.
  const canvas = page.locator('.flat-map canvas');
  const facts = page.locator('.node-panel .hint');
  const box = await canvas.boundingBox();
  const nodeAt = async (left, top) => {
    await page.mouse.move(box.x + left, box.y + top);
    return facts.textContent();
  };
  const [left, top] = await canvas.evaluate((surface) => {
    const area = surface.getBoundingClientRect();
    for (let y = 10; y < area.height - 50; y += 12) {
      for (let x = 10; x < area.width - 80; x += 12) {
        const at = { clientX: area.left + x, clientY: area.top + y };
        surface.dispatchEvent(new PointerEvent('pointermove', at));
        if (document.querySelector('.node-panel .hint').textContent.startsWith('Node'))
          return [x, y];
      }
    }
    throw new Error('expected a node in the map');
  });
  const node = await facts.textContent();
  await page.mouse.down();
  await page.mouse.move(box.x + left + 70, box.y + top + 40, { steps: 3 });
  await page.mouse.up();
  await nodeAt(5, 5);
  assert.equal(await nodeAt(left + 70, top + 40), node);
  await page.waitForTimeout(500); // the address is written with a delay
  assert.doesNotMatch(page.url(), /node=/);
  await canvas.press('ArrowRight');
  await nodeAt(5, 5);
  assert.equal(await nodeAt(left + 40, top + 40), node);
  await page.getByText('Nodes as a table').click();
  await page.locator('.node-list tbody button').first().click();
  await page.locator('.node-panel svg.pose').waitFor();
  await page.waitForURL(/node=\d/);
});

// The linear colour of a text such as rgb(255, 0, 128).
const linearOf = (text) =>
  text
    .match(/\d+/g)
    .slice(0, 3)
    .map((part) => {
      const value = Number(part) / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });

// Checks the drawn dots against their positions and clips, in any order. `colorOf`: linear colour of a
// clip; undefined if it is not shown.
function checkDots(drawn, positions, clips, colorOf) {
  const key = (values, i) =>
    values
      .slice(3 * i, 3 * i + 3)
      .map(Math.fround)
      .join();
  const expected = new Map(); // colours by place: frames can be at the same place
  let count = 0;
  clips.forEach((clip, i) => {
    const color = colorOf(clip);
    if (!color) return;
    ++count;
    const at = key(positions, i);
    expected.set(at, [...(expected.get(at) ?? []), color]);
  });
  const found = drawn.filter(
    ({ kind, positions: places }) => kind === 'points' && places.length === 3 * count,
  );
  assert.equal(found.length, 1, `${count} dots`);
  const [dots] = found;
  for (let dot = 0; dot < count; ++dot) {
    const at = key(dots.positions, dot);
    const rest = expected.get(at);
    assert.ok(rest, `a dot at ${at}`);
    const color = dots.colors.slice(3 * dot, 3 * dot + 3);
    const index = rest.findIndex((each) => distance(each, color) < 0.005);
    assert.ok(index >= 0, `${color} instead of ${rest.join(' or ')} at ${at}`);
    rest.splice(index, 1);
  }
}

test('nodes and frames have the colour of their label or clip in the legend', async (t) => {
  const page = await open(t, '?layer=5', {}, recordDrawing);
  const { header, mainClips, means, points, pointClips } = await readMap('demo', 5, 20000);
  assert.ok(pointClips.length > 1000, `${pointClips.length} frames`);
  // Colours of the legend by name.
  const legend = async (item) =>
    new Map(
      await page
        .locator(`.legend ${item}:has(.swatch)`)
        .evaluateAll((items) =>
          items.map((node) => [
            node.textContent,
            getComputedStyle(node.querySelector('.swatch')).backgroundColor,
          ]),
        ),
    );
  const check = (names, colors, hidden = undefined) => {
    const linear = new Map([...colors].map(([name, color]) => [name, linearOf(color)]));
    assert.ok(new Set([...linear.values()].map(String)).size >= 3, 'three colours');
    const colorOf = (clip) => (names[clip] === hidden ? undefined : linear.get(names[clip]));
    return whenDrawn(page, '.map canvas', (drawn) => {
      checkDots(drawn, means, mainClips, colorOf);
      checkDots(drawn, points, pointClips, colorOf);
    });
  };
  const labels = header.labels.map((label) => label || '(no label)');
  const labelColors = await legend('.legend-label');
  await check(labels, labelColors);
  // The frames of a label that is hidden are not drawn.
  const hide = page.getByRole('group', { name: 'Legend' }).getByRole('button', { name: 'climb' });
  await hide.click();
  await check(labels, labelColors, 'climb');
  await hide.click();
  assert.equal(await page.locator('.legend-clip').count(), 0);
  await page.locator('.map-controls').getByLabel('Colour').selectOption('clip');
  await page.locator('.legend-clip').first().waitFor();
  await page.waitForURL(/color=clip/);
  const clips = header.clips.map((name) => name.split('/').at(-1));
  const colors = await legend('.legend-clip');
  assert.deepEqual([...colors.keys()], clips);
  await check(clips, colors);
  await page.reload();
  await page.locator('.legend-clip').first().waitFor();
  await check(clips, colors);
});

test('axe reports nothing', async (t) => {
  const page = await open(t, '?layer=4');
  await page.locator('.axis-ends svg').first().waitFor();
  await checkAccessibility(page);
});
