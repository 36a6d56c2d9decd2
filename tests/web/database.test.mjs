// The view of a database: map of states, layers, Table I.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage, shown } from './support/browser.mjs';
import { recordDrawing, whenDrawn } from './support/drawing.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { clearNodes, placesOf, readMap } from './support/state_map.mjs';

async function open(t, query = '', options = {}, prepare = undefined) {
  const page = await newPage(t, options);
  await prepare?.(page);
  await page.goto(`${setup.open}/#/database/demo${query}`);
  await shown(page);
  await page.locator('.map-controls output', { hasText: 'Layer' }).waitFor();
  return page;
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
  await page.locator('.node-panel svg.pose .marker').first().waitFor();
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
  const row = (name) => page.locator('table.properties tr', { hasText: name }).locator('td');
  await row('Nodes in the bottom layer').waitFor();
  const number = (value) => value.toLocaleString('en-GB');
  assert.equal(await row('Clips').first().textContent(), number(statistics.clipCount));
  assert.equal(
    await row('Nodes in the bottom layer').textContent(),
    number(statistics.bottomNodeCount),
  );
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
        if (document.querySelector('.node-panel .hint').textContent.startsWith('Node')) return [x, y];
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
  assert.doesNotMatch(page.url(), /node=/);
  await canvas.press('ArrowRight');
  await nodeAt(5, 5);
  assert.equal(await nodeAt(left + 40, top + 40), node);
  await page.getByText('Nodes as a table').click();
  await page.locator('.node-list tbody button').first().click();
  await page.locator('.node-panel svg.pose').waitFor();
  assert.match(page.url(), /node=\d/);
});

// The linear colour of a text such as rgb(255, 0, 128).
const linearOf = (text) =>
  text.match(/\d+/g).slice(0, 3).map((part) => {
    const value = Number(part) / 255;
    return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
  });

test('nodes have the colour of their label or clip in the legend', async (t) => {
  const page = await open(t, '?layer=5', {}, recordDrawing);
  const { header, mainClips, means } = await readMap('demo', 5, 20000);
  // Colours of the legend by name.
  const legend = async (item) =>
    new Map(
      await page.locator(`.legend ${item}:has(.swatch)`).evaluateAll((items) =>
        items.map((node) => [
          node.textContent,
          getComputedStyle(node.querySelector('.swatch')).backgroundColor,
        ]),
      ),
    );
  const check = (names, colors) =>
    whenDrawn(page, '.map canvas', (drawn) => {
      const dots = drawn.find(({ kind, positions }) => kind === 'points' && positions.length === means.length);
      assert.ok(dots, 'a dot for each node');
      const key = (values, i) => values.slice(3 * i, 3 * i + 3).map(Math.fround).join();
      const nodeAt = new Map(mainClips.map((_, node) => [key(means, node), node]));
      const seen = new Set();
      for (let dot = 0; dot < mainClips.length; ++dot) {
        const node = nodeAt.get(key(dots.positions, dot));
        assert.notEqual(node, undefined, `a node at ${key(dots.positions, dot)}`);
        const name = names[mainClips[node]];
        const expected = linearOf(colors.get(name));
        expected.forEach((value, i) =>
          assert.ok(Math.abs(dots.colors[3 * dot + i] - value) < 0.005, `${name}: ${expected}`),
        );
        seen.add(expected.join());
      }
      assert.equal(seen.size, new Set(mainClips.map((main) => names[main])).size);
      assert.ok(seen.size >= 3, `${seen.size} colours`);
    });
  const labels = header.labels.map((label) => label || '(no label)');
  await check(labels, await legend('.legend-label'));
  assert.equal(await page.locator('.legend-clip').count(), 0);
  await page.locator('.map-controls').getByLabel('Colour').selectOption('clip');
  await page.locator('.legend-clip').first().waitFor();
  assert.match(page.url(), /color=clip/);
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
