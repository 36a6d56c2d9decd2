// What a page draws with WebGL, as numbers: places and colours of spheres and bones, lines and dots.
import { until } from './browser.mjs';

// Records the drawings of the pages that `page` opens later.
export function recordDrawing(page) {
  return page.addInitScript(() => {
    const prototype = WebGL2RenderingContext.prototype;
    const contents = new WeakMap(); // numbers in each buffer
    const pictures = new Map(); // what was drawn since the last clear, by canvas
    const after = (name, call) => {
      const original = prototype[name];
      prototype[name] = function (...parameters) {
        call(this, ...parameters);
        return original.apply(this, parameters);
      };
    };
    const bound = (gl, target) =>
      target === gl.ARRAY_BUFFER ? gl.getParameter(gl.ARRAY_BUFFER_BINDING) : null;
    after('bufferData', (gl, target, data) => {
      const buffer = bound(gl, target);
      if (buffer && data instanceof Float32Array) contents.set(buffer, data.slice());
    });
    after('bufferSubData', (gl, target, offset, data, start = 0, length = undefined) => {
      const buffer = bound(gl, target);
      if (!buffer || !(data instanceof Float32Array)) return;
      const end = length === undefined ? undefined : start + length;
      contents.get(buffer)?.set(data.subarray(start, end), offset / 4);
    });
    after('clear', (gl) => pictures.set(gl.canvas, []));
    const draw = (gl, mode, first, count, instances) => {
      const program = gl.getParameter(gl.CURRENT_PROGRAM);
      const buffers = {};
      for (const name of ['position', 'color', 'instanceMatrix', 'instanceColor']) {
        const at = gl.getAttribLocation(program, name);
        if (at < 0 || !gl.getVertexAttrib(at, gl.VERTEX_ATTRIB_ARRAY_ENABLED)) continue;
        buffers[name] = gl.getVertexAttrib(at, gl.VERTEX_ATTRIB_ARRAY_BUFFER_BINDING);
      }
      pictures.get(gl.canvas)?.push({ mode, first, count, instances, buffers });
    };
    after('drawArrays', (gl, mode, first, count) => draw(gl, mode, first, count, 0));
    after('drawArraysInstanced', draw);
    after('drawElementsInstanced', (gl, mode, count, _type, _offset, instances) =>
      draw(gl, mode, 0, count, instances),
    );
    window.drawingOf = (canvas) => {
      const part = (drawn, name, first, count, size) => [
        ...(contents.get(drawn.buffers[name])?.subarray(first * size, (first + count) * size) ??
          []),
      ];
      const kinds = { 0: 'points', 1: 'lines', 4: 'triangles' };
      return (pictures.get(canvas) ?? []).map((drawn) => ({
        kind: kinds[drawn.mode],
        instances: drawn.instances,
        positions: drawn.instances > 0 ? [] : part(drawn, 'position', drawn.first, drawn.count, 3),
        colors: drawn.instances > 0 ? [] : part(drawn, 'color', drawn.first, drawn.count, 3),
        matrices: part(drawn, 'instanceMatrix', 0, drawn.instances, 16),
        instanceColors: part(drawn, 'instanceColor', 0, drawn.instances, 3),
      }));
    };
  });
}

/**
 * The last picture of a canvas, one entry for each draw call: kind ('points', 'lines' or
 * 'triangles'), positions and linear colours of its vertices, or number, matrices and linear colours
 * of its instances.
 */
export async function drawnOn(page, selector) {
  return page.evaluate((css) => window.drawingOf(document.querySelector(css)), selector);
}

// Positions of the instances of a draw call, as one list of x, y, z.
export const placesOfInstances = ({ matrices }) =>
  Array.from(
    { length: 3 * (matrices.length / 16) },
    (_, i) => matrices[16 * Math.floor(i / 3) + 12 + (i % 3)],
  );

// Largest difference of two lists of numbers; Infinity if their lengths differ.
export function distance(a, b) {
  if (a.length !== b.length) return Infinity;
  return a.reduce((most, value, i) => Math.max(most, Math.abs(value - b[i])), 0);
}

// Waits until `check`, called with the last picture of a canvas, does not throw; throws its last
// error after `seconds`.
export async function whenDrawn(page, selector, check, seconds = 20) {
  return until(async () => check(await drawnOn(page, selector)), seconds);
}
