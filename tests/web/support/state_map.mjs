// Reads a map of states as the page does, and computes where the page draws it.
import { setup } from './setup.mjs';

function envelope(message) {
  const body = Buffer.from(JSON.stringify(message));
  const head = Buffer.alloc(5);
  head.writeUInt32BE(body.length, 1);
  return Buffer.concat([head, body]);
}

// The messages of a server stream of the open server.
export async function readStream(method, request) {
  const response = await fetch(`${setup.open}/motiondb.v1.${method}`, {
    method: 'POST',
    headers: { 'content-type': 'application/connect+json' },
    body: envelope(request),
  });
  const bytes = Buffer.from(await response.arrayBuffer());
  const messages = [];
  for (let at = 0; at < bytes.length; ) {
    const end = at + 5 + bytes.readUInt32BE(at + 1);
    const message = JSON.parse(bytes.subarray(at + 5, end).toString());
    if (bytes[at] === 0) messages.push(message);
    else if (message.error) throw new Error(JSON.stringify(message.error));
    at = end;
  }
  return messages;
}

function floats(messages, part, field) {
  const blocks = messages.flatMap((m) => (m[part] ? [Buffer.from(m[part][field], 'base64')] : []));
  const bytes = Buffer.concat(blocks);
  return Array.from({ length: bytes.length / 4 }, (_, i) => bytes.readFloatLE(4 * i));
}

// Header, node ids, means and points of a layer; undefined: the bottom layer.
export async function readMap(database, layer, maxPoints) {
  const parent = `databases/${database}/models/current`;
  const messages = await readStream('ViewService/ReadStateMap', { parent, layer, maxPoints });
  return {
    header: messages[0].header,
    ids: messages.flatMap((m) => m.nodes?.nodeIds ?? []),
    means: floats(messages, 'nodes', 'means'),
    points: floats(messages, 'points', 'positions'),
  };
}

const minus = (a, b) => a.map((value, i) => value - b[i]);
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const unit = (a) => a.map((value) => value / Math.hypot(...a));

// Places of the means on a canvas, px, for a camera at `eye` that looks at the middle of the map.
// The page shows a map with radius 3 and a vertical field of view of 40 degrees.
export function placesOf({ means, points }, eye, width, height) {
  const values = means.concat(points);
  const axis = (k) => values.filter((_, i) => i % 3 === k);
  const low = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.min(a, b)));
  const high = [0, 1, 2].map((k) => axis(k).reduce((a, b) => Math.max(a, b)));
  const centre = low.map((value, k) => (value + high[k]) / 2);
  const scale = 3 / Math.hypot(...low.map((value, k) => (high[k] - value) / 2));
  const ahead = unit(eye.map((value) => -value));
  const right = unit(cross(ahead, [0, 0, 1]));
  const up = cross(right, ahead);
  const focal = height / 2 / Math.tan((20 * Math.PI) / 180);
  const places = [];
  for (let i = 0; i < means.length; i += 3) {
    const at = minus(
      minus(means.slice(i, i + 3), centre).map((value) => value * scale),
      eye,
    );
    const depth = dot(at, ahead);
    places.push({
      x: width / 2 + (focal * dot(at, right)) / depth,
      y: height / 2 - (focal * dot(at, up)) / depth,
    });
  }
  return places;
}
