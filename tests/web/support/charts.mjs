// What charts (uPlot) draw on their canvases, as numbers.
import assert from 'node:assert/strict';

// Records the drawings of the charts of the pages that `page` opens later.
export function recordCharts(page) {
  return page.addInitScript(() => {
    const after = (prototype, name, call) => {
      const original = prototype[name];
      prototype[name] = function (...parameters) {
        call(this, ...parameters);
        return original.apply(this, parameters);
      };
    };
    const corners = new WeakMap(); // of paths
    for (const name of ['moveTo', 'lineTo'])
      after(Path2D.prototype, name, (path, x, y) => {
        if (!corners.has(path)) corners.set(path, []);
        corners.get(path).push([x, y]);
      });
    const pictures = new WeakMap(); // since the last clear, by canvas
    const context = CanvasRenderingContext2D.prototype;
    after(context, 'clearRect', ({ canvas }) => pictures.set(canvas, { lines: [], texts: [] }));
    after(context, 'stroke', ({ canvas, strokeStyle }, path) => {
      const points = path && corners.get(path);
      if (points) pictures.get(canvas)?.lines.push({ color: strokeStyle, points });
    });
    after(context, 'fillText', ({ canvas }, text, x, y) =>
      pictures.get(canvas)?.texts.push({ text, x, y }),
    );
    window.chartOf = (canvas) => pictures.get(canvas);
  });
}

// The function from a value to its place on an axis, px, from the numbers at this axis.
function scaleOf(texts, along, across) {
  const numbers = texts
    .map(({ text, ...at }) => ({ value: Number(text.replaceAll(',', '')), ...at }))
    .filter(({ value }) => Number.isFinite(value));
  // The numbers of an axis are in a row.
  const rows = [];
  for (const each of numbers) {
    const row = rows.find(([first]) => first[across] === each[across]);
    if (row) row.push(each);
    else rows.push([each]);
  }
  const axis = rows.sort((a, b) => b.length - a.length)[0] ?? [];
  assert.ok(axis.length >= 2, `numbers of an axis, got ${JSON.stringify(texts)}`);
  const [first, last] = [axis[0], axis[axis.length - 1]];
  const pixels = (last[along] - first[along]) / (last.value - first.value);
  return (value) => first[along] + (value - first.value) * pixels;
}

/**
 * Fails unless the lines of a chart go through the points [x, y] of `lines`, one list for each line, by
 * the numbers at its axes. Returns their colours.
 */
export async function checkLines(canvas, lines, what) {
  const picture = await canvas.evaluate((node) => window.chartOf(node));
  const x = scaleOf(picture.texts, 'x', 'y');
  const y = scaleOf(picture.texts, 'y', 'x');
  assert.equal(picture.lines.length, lines.length, `lines of ${what}`);
  for (const [i, points] of lines.entries()) {
    const drawn = picture.lines[i].points;
    assert.equal(drawn.length, points.length, `points of line ${i} of ${what}`);
    for (const [k, [time, value]] of points.entries()) {
      const at = [x(time), y(value)];
      const away = Math.max(...at.map((pixel, axis) => Math.abs(pixel - drawn[k][axis])));
      assert.ok(away < 2, `point ${k} of line ${i} of ${what}: at ${drawn[k]}, not ${at}`);
    }
  }
  return picture.lines.map(({ color }) => color);
}

/** The values of each line of a chart, by the numbers at its left axis. */
export async function lineValues(canvas) {
  const picture = await canvas.evaluate((node) => window.chartOf(node));
  const y = scaleOf(picture.texts, 'y', 'x');
  const pixels = y(1) - y(0);
  return picture.lines.map(({ points }) => points.map(([, at]) => (at - y(0)) / pixels));
}
