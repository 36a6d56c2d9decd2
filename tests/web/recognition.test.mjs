// The answers of a query as the page draws them: ribbon with unknown motion, node path, next nodes and
// generation probability, with the numbers of the server.
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { newPage } from './support/browser.mjs';
import { checkLines, recordCharts } from './support/charts.mjs';
import { distance } from './support/drawing.mjs';
import { storeKnown } from './support/known.mjs';
import { call } from './support/server.mjs';
import { setup } from './support/setup.mjs';
import { placesOf, readMap, wholeMapEye } from './support/state_map.mjs';
import { motionOf } from './support/stream.mjs';

const kDatabase = 'databases/known';
const kClip = `${kDatabase}/clips/boxing_b`;
const kFilter = 'label != boxing'; // so that parts of the clip are unknown
const kAt = 1; // s
const kSmallestArea = 0.004; // probability of the smallest area of the ribbon

const percent = (value) => `${Math.round(100 * value)} %`;

const base64Of = (values) => Buffer.from(Float32Array.from(values).buffer).toString('base64');

// The clip as an observation, all of it or frames of it.
async function observe() {
  const { frames, frameRateHz } = await motionOf(setup.open, kClip);
  const { body } = await call(setup.open, 'ClipService/GetClip', { name: kClip });
  const part = (first, count) => ({
    markers: {
      frameRateHz,
      frameCount: count,
      positions: base64Of(frames.slice(first, first + count).flat()),
      legLengthM: body.clip.legLengthM,
    },
  });
  return { all: part(0, frames.length), part, frameRateHz, seconds: frames.length / frameRateHz };
}

async function ask(method, request) {
  const { status, body } = await call(setup.open, `QueryService/${method}`, {
    database: kDatabase,
    filter: kFilter,
    ...request,
  });
  assert.equal(status, 200, JSON.stringify(body));
  return body;
}

// Windows in order, each with the time that it stands for in the ribbon: [begin, end].
async function recognize(request) {
  const { windows } = await ask('Recognize', { windowSeconds: 0.4, ...request });
  const middles = windows.map(
    ({ startSeconds = 0, endSeconds }) => (startSeconds + endSeconds) / 2,
  );
  const last = windows.length - 1;
  return windows.map((window, i) => ({
    ...window,
    middle: middles[i],
    begin: i === 0 ? (window.startSeconds ?? 0) : (middles[i - 1] + middles[i]) / 2,
    end: i === last ? window.endSeconds : (middles[i] + middles[i + 1]) / 2,
    labels: window.labels.map(({ label, probability = 0 }) => ({ label, probability })),
  }));
}

// The areas of a window, from the bottom: unknown motion, then the labels in order of name.
function areasOf({ begin, end, labels, unknownProbability = 0 }) {
  const sorted = [...labels].sort((a, b) => (a.label < b.label ? -1 : 1));
  const parts = [{ label: 'unknown motion', probability: unknownProbability }, ...sorted];
  let bottom = 0;
  return parts.flatMap(({ label, probability }) => {
    const area = { label, begin, end, bottom, top: bottom + probability };
    bottom = area.top;
    return probability >= kSmallestArea ? [area] : [];
  });
}

// The areas are as wide as the times of the windows, as high as the probabilities, and have the
// colours of the legend; unknown motion is hatched.
async function checkRibbon(page, windows, seconds) {
  const picture = page.locator('.ribbon svg');
  const [, , width, height] = (await picture.getAttribute('viewBox')).split(' ').map(Number);
  const drawn = await page.locator('.ribbon').evaluate((ribbon) => ({
    colors: [...ribbon.querySelectorAll('.legend-clip')].map(
      ({ textContent, firstElementChild }) => [
        textContent,
        firstElementChild.style.backgroundColor,
      ],
    ),
    areas: [...ribbon.querySelectorAll('svg > g rect')].map((rect) => ({
      place: ['x', 'width', 'y', 'height'].map((name) => Number(rect.getAttribute(name))),
      fill: getComputedStyle(rect).fill,
    })),
  }));
  const colors = new Map(drawn.colors);
  assert.deepEqual([...colors.keys()], ['climb', 'jump', 'unknown motion']);
  const expected = windows.flatMap(areasOf);
  assert.equal(drawn.areas.length, expected.length);
  for (const [i, { label, begin, end, bottom, top }] of expected.entries()) {
    const across = [begin, end - begin].map((time) => (time / seconds) * width);
    const along = [1 - top, top - bottom].map((part) => part * height);
    const { place, fill } = drawn.areas[i];
    assert.ok(distance(place, [...across, ...along]) < 0.01, `area ${i} of ${label}: ${place}`);
    assert.equal(fill, label === 'unknown motion' ? 'url("#unknown-motion")' : colors.get(label));
  }
  const hatching = await page
    .locator('#unknown-motion rect')
    .evaluateAll((rects) => rects.map((rect) => getComputedStyle(rect).fill));
  assert.equal(new Set([...hatching, 'none']).size, 3, `ground and lines: ${hatching}`);
}

// The list has the runs of windows with the same most probable label, the text below the ribbon the
// present window.
async function checkTexts(page, windows) {
  const winnerOf = ({ labels: [first], unknownProbability: unknown = 0 }) =>
    unknown > first.probability ? { label: 'unknown motion', probability: unknown } : first;
  const runs = [];
  for (const window of windows) {
    const { label, probability } = winnerOf(window);
    const last = runs.at(-1);
    if (last?.label === label) last.probabilities.push(probability);
    else runs.push({ label, begin: window.begin, probabilities: [probability] });
    runs.at(-1).end = window.end;
  }
  const texts = runs.map(({ label, begin, end, probabilities }) => {
    const mean = probabilities.reduce((sum, value) => sum + value, 0) / probabilities.length;
    return `${begin.toFixed(2)} s to ${end.toFixed(2)} s: ${label} (${percent(mean)})`;
  });
  assert.ok(
    texts.some((text) => text.includes('unknown motion')),
    texts.join('; '),
  );
  assert.deepEqual(await page.locator('.ribbon-runs li').allTextContents(), texts);
  const present = windows.find(({ end }) => kAt < end);
  const labels = present.labels.map(({ label, probability }) => `${label} ${percent(probability)}`);
  const unknown = `unknown motion ${percent(present.unknownProbability)}`;
  const now = `${[...labels, unknown].join(', ')}; familiarity ${percent(present.familiarity ?? 0)}`;
  assert.equal(await page.locator('.ribbon-now').textContent(), now);
}

// The path of nodes on the map, and the texts about the moment.
async function checkPath(page, observed) {
  const count = Math.round(0.4 * observed.frameRateHz) + 1;
  const first = Math.round(kAt * observed.frameRateHz) - count + 1;
  const { paths, layer } = await ask('Estimate', { observation: observed.part(first, count) });
  const {
    nextNodes,
    state,
    unknownProbability,
    layer: nextLayer,
  } = await ask('Predict', {
    observation: observed.all,
    atSeconds: kAt,
    historySeconds: 0.4,
  });
  const path = paths[0].nodeIds.filter((id, i, all) => id !== all[i - 1]);
  assert.ok(path.length > 1, `a path of several nodes: ${path}`);
  await page.getByText(`Path: ${path.join(', ')}`, { exact: true }).waitFor();
  const map = await readMap('known', layer, 10_000);
  const { width, height } = await page.locator('.path-map canvas').boundingBox();
  const places = placesOf(map, wholeMapEye(width, height), width, height);
  const at = (id) => places[map.ids.indexOf(id)];
  const next = nextNodes[0].nodeId;
  const marked = [...new Set([...path, next])];
  const emphasis = page.locator('.path-map .map-emphasis');
  const circles = emphasis.locator('circle');
  await circles.nth(marked.length - 1).waitFor();
  const drawn = await circles.evaluateAll((all) =>
    all.map((circle) => ({
      place: [circle.cx.baseVal.value, circle.cy.baseVal.value],
      color: getComputedStyle(circle).fill.match(/\d+/g).map(Number),
    })),
  );
  assert.equal(drawn.length, marked.length);
  // In the light theme the path is brown, the next node blue.
  for (const [i, node] of marked.entries()) {
    const { place, color } = drawn[i];
    const { x, y } = at(node);
    assert.ok(distance(place, [x, y]) < 0.1, `node ${node}: ${place} instead of ${x}, ${y}`);
    const [red, , blue] = color;
    assert.ok(node === next ? blue > red : red > blue, `colour of node ${node}: ${color}`);
  }
  const line = await emphasis.locator('path').getAttribute('d');
  const steps = path.slice(1).map((id, i) => [path[i], id].map(at).flatMap(({ x, y }) => [x, y]));
  assert.ok(distance(line.match(/[-\d.e]+/g).map(Number), steps.flat()) < 0.1 * steps.length, line);
  const panel = page.getByRole('region', { name: 'Estimation and prediction' });
  const facts =
    `At ${kAt.toFixed(2)} s the motion is in node ${state.nodeId} of layer ${nextLayer} ` +
    `(${percent(state.probability)}); unknown motion ${percent(unknownProbability)}.`;
  await panel.getByText(facts, { exact: true }).waitFor();
  const texts = await panel.locator('li').allTextContents();
  assert.equal(texts.length, Math.min(5, nextNodes.length));
  for (const [i, text] of texts.entries()) {
    const { nodeId, probability = 0, clips = [] } = nextNodes[i];
    assert.ok(text.startsWith(`Next node ${nodeId}: ${percent(probability)}`), text);
    for (const clip of clips.slice(0, 3)) assert.ok(text.includes(clip.split('/').at(-1)), text);
  }
}

// #26399c as in the style of an element.
function rgbText(color) {
  const parts = [1, 3, 5].map((at) => Number.parseInt(color.slice(at, at + 2), 16));
  return `rgb(${parts.join(', ')})`;
}

// Figs. 13 to 15: a line for each clip at three layers, in the colour of its label in the ribbon.
async function checkProfiles(page, observed) {
  await page.getByRole('button', { name: 'Show generation probability' }).press('Enter');
  const { body } = await call(setup.open, 'ModelService/GetModel', {
    name: `${kDatabase}/models/current`,
  });
  const depth = body.model.nodesPerLayer.length;
  const layers = [1, 0.6, 0.4].map((part) => Math.round(part * depth));
  const legend = new Map(
    await page
      .locator('.ribbon .legend-clip')
      .evaluateAll((entries) =>
        entries.map((entry) => [entry.textContent, entry.firstElementChild.style.backgroundColor]),
      ),
  );
  const charts = page.locator('figure.profile');
  for (const [i, layer] of layers.entries()) {
    const windows = await recognize({ observation: observed.all, method: 'METHOD_PAPER', layer });
    const clips = windows[0].clips.map(({ clip, label }) => ({ clip, label }));
    assert.equal(clips.length, 8); // without the clips of boxing
    clips.sort((a, b) => (a.clip < b.clip ? -1 : 1)); // which have the names of their labels
    const chart = charts.nth(i);
    await chart.locator('canvas').waitFor();
    const valueIn = ({ clips: all }, name) =>
      all.find(({ clip }) => clip === name).logProbability ?? 0;
    const lines = clips.map(({ clip }) =>
      windows.map((window) => [window.middle, valueIn(window, clip)]),
    );
    const colors = await checkLines(chart.locator('canvas'), lines, `layer ${layer}`);
    const pairs = new Set(clips.map(({ label }, at) => `${label} ${colors[at]}`));
    assert.equal(pairs.size, 2, [...pairs].join('; '));
    assert.equal(new Set(colors).size, 2);
    for (const [at, { label }] of clips.entries()) {
      assert.equal(rgbText(colors[at]), legend.get(label), `line of ${label}`);
    }
    const best = windows.map(
      (window) =>
        window.clips.reduce((a, b) => ((b.logProbability ?? 0) > (a.logProbability ?? 0) ? b : a))
          .label,
    );
    const wins = ['climb', 'jump'].map((label) => best.filter((each) => each === label).length);
    const [name, most] = wins[0] > wins[1] ? ['climb', wins[0]] : ['jump', wins[1]];
    const caption = `Layer ${layer}: ${name} is most probable in ${most} of ${windows.length} windows`;
    assert.equal(await chart.locator('figcaption').textContent(), caption);
  }
  assert.equal(await charts.count(), layers.length);
}

test('the answers of a query are those of the server', async (t) => {
  await storeKnown();
  const observed = await observe();
  const windows = await recognize({ observation: observed.all, topCount: 1 });
  const page = await newPage(t, { viewport: { width: 900, height: 700 } });
  await recordCharts(page);
  const query = new URLSearchParams({ clip: 'boxing_b', filter: kFilter, at: kAt, without: 0 });
  await page.goto(`${setup.open}/#/query/known?${query}`);
  await page.locator('.ribbon rect:visible').first().waitFor();
  await t.test('ribbon', () => checkRibbon(page, windows, observed.seconds));
  await t.test('texts of the ribbon', () => checkTexts(page, windows));
  await t.test('path of nodes', () => checkPath(page, observed));
  await t.test('generation probability', () => checkProfiles(page, observed));
});
