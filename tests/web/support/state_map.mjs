// Reads a map of states as the page does, and computes where the page draws it.
import { project } from './projection.mjs';
import { setup } from './setup.mjs';
import { floatsOf, stream } from './stream.mjs';

const floats = (messages, part, field) =>
  messages.flatMap((message) => (message[part] ? floatsOf(message[part][field]) : []));

/**
 * Header, node ids, main clips, means, semi-axes, transitions [from, to, probability] (node ids),
 * points and their clips of a layer; undefined: the bottom layer. `clip`: id of the clip whose graph
 * it is.
 */
export async function readMap(database, layer, maxPoints, clip = '') {
  const parent = `databases/${database}/models/current`;
  const request = { parent, layer, maxPoints, clip: clip && `databases/${database}/clips/${clip}` };
  const messages = await stream(setup.open, 'ViewService/ReadStateMap', request);
  return {
    header: messages[0].header,
    ids: messages.flatMap((m) => m.nodes?.nodeIds ?? []),
    mainClips: messages.flatMap((m) => m.nodes?.mainClips ?? []),
    means: floats(messages, 'nodes', 'means'),
    semiAxes: floats(messages, 'nodes', 'semiAxes'),
    transitions: messages.flatMap(({ transitions: part }) =>
      (part?.fromNodeIds ?? []).map((from, i) => [from, part.toNodeIds[i], part.probabilities[i]]),
    ),
    points: floats(messages, 'points', 'positions'),
    pointClips: messages.flatMap((m) => m.points?.clips ?? []),
  };
}

// Places of the means on a canvas, px, for a camera at `eye` that looks at the middle of the map.
// The page shows a map with radius 3.
export function placesOf({ means, points }, eye, width, height, degrees = 40) {
  const values = means.concat(points);
  const axis = (k) => values.filter((_, i) => i % 3 === k);
  const low = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.min(a, b)));
  const high = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.max(a, b)));
  const centre = low.map((value, k) => (value + high[k]) / 2);
  const scale = 3 / Math.hypot(...low.map((value, k) => (high[k] - value) / 2));
  const places = [];
  for (let i = 0; i < means.length; i += 3) {
    const at = means.slice(i, i + 3).map((value, k) => (value - centre[k]) * scale);
    const [x, y] = project(at, eye, [0, 0, 0], width, height, degrees);
    places.push({ x, y });
  }
  return places;
}

// Where the camera is that shows the whole map in three axes.
export function wholeMapEye(width, height) {
  const direction = [0.6, -0.9, 0.55];
  const reach = 3 / Math.sin((20 * Math.PI) / 180) / Math.min(1, width / height);
  return direction.map((value) => (value * reach) / Math.hypot(...direction));
}

// The `count` nodes that are farthest from all others on the canvas, as indices.
export function clearNodes(places, count) {
  const alone = places.map((place) =>
    places.reduce(
      (least, other) =>
        other === place ? least : Math.min(least, Math.hypot(place.x - other.x, place.y - other.y)),
      Infinity,
    ),
  );
  return [...alone.keys()].sort((a, b) => alone[b] - alone[a]).slice(0, count);
}
