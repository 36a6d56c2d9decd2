// The camera of the page's scenes (client/web/src/scene/scene.ts): 40 degrees high, z up.

const minus = (a, b) => a.map((value, axis) => value - b[axis]);
const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const unit = (a) => a.map((value) => value / Math.hypot(...a));

// Pixel [x, y] of a point on a canvas of width x height, for a camera at `eye` that looks at `target`
// and sees `degrees` from below to above.
export function project(point, eye, target, width, height, degrees = 40) {
  const ahead = unit(minus(target, eye));
  const right = unit(cross(ahead, [0, 0, 1]));
  const up = cross(right, ahead);
  const offset = minus(point, eye);
  const scale = height / 2 / Math.tan((degrees * Math.PI) / 360) / dot(offset, ahead);
  return [width / 2 + scale * dot(offset, right), height / 2 - scale * dot(offset, up)];
}
