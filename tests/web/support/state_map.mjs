// Reads a map of states as the page does, and computes where the page draws it.
import { project } from './projection.mjs';
import { setup } from './setup.mjs';
import { floatsOf, stream } from './stream.mjs';

const floats = (messages, part, field) =>
  messages.flatMap((message) => (message[part] ? floatsOf(message[part][field]) : []));

// Header, node ids, main clips, means and points of a layer; undefined: the bottom layer.
export async function readMap(database, layer, maxPoints) {
  const parent = `databases/${database}/models/current`;
  const messages = await stream(setup.open, 'ViewService/ReadStateMap', { parent, layer, maxPoints });
  return {
    header: messages[0].header,
    ids: messages.flatMap((m) => m.nodes?.nodeIds ?? []),
    mainClips: messages.flatMap((m) => m.nodes?.mainClips ?? []),
    means: floats(messages, 'nodes', 'means'),
    points: floats(messages, 'points', 'positions'),
  };
}

// Places of the means on a canvas, px, for a camera at `eye` that looks at the middle of the map.
// The page shows a map with radius 3 and a vertical field of view of 40 degrees.
export function placesOf({ means, points }, eye, width, height) {
  const values = means.concat(points);
  const axis = (k) => values.filter((_, i) => i % 3 === k);
  const low = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.min(a, b)));
  const high = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.max(a, b)));
  const centre = low.map((value, k) => (value + high[k]) / 2);
  const scale = 3 / Math.hypot(...low.map((value, k) => (high[k] - value) / 2));
  const places = [];
  for (let i = 0; i < means.length; i += 3) {
    const at = means.slice(i, i + 3).map((value, k) => (value - centre[k]) * scale);
    const [x, y] = project(at, eye, [0, 0, 0], width, height);
    places.push({ x, y });
  }
  return places;
}
