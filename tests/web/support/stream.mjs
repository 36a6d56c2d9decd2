// Calls that stream responses, without a browser.

function envelopeOf(request) {
  const message = Buffer.from(JSON.stringify(request));
  const head = Buffer.alloc(5);
  head.writeUInt32BE(message.length, 1);
  return Buffer.concat([head, message]);
}

// Calls an RPC of the server with Connect's envelopes; yields the messages as JSON until the stream
// ends.
export async function* watch(server, method, request, signal = undefined) {
  const response = await fetch(`${server}/motiondb.v1.${method}`, {
    method: 'POST',
    headers: { 'content-type': 'application/connect+json' },
    body: envelopeOf(request),
    signal,
  });
  let rest = Buffer.alloc(0);
  for await (const block of response.body) {
    rest = Buffer.concat([rest, block]);
    while (rest.length >= 5 && rest.length >= 5 + rest.readUInt32BE(1)) {
      const size = rest.readUInt32BE(1);
      const text = rest.subarray(5, 5 + size).toString();
      if (rest[0] === 0) yield JSON.parse(text);
      else if (JSON.parse(text).error !== undefined) throw new Error(text);
      rest = rest.subarray(5 + size);
    }
  }
}

// Calls such an RPC; returns all its messages.
export async function stream(server, method, request) {
  const messages = [];
  for await (const message of watch(server, method, request)) messages.push(message);
  return messages;
}

// The answer of a route in place of such an RPC: the stream ends with an error.
export function failedStream(code, text) {
  const message = Buffer.from(JSON.stringify({ error: { code, message: text } }));
  const head = Buffer.alloc(5);
  head[0] = 2;
  head.writeUInt32BE(message.length, 1);
  const contentType = 'application/connect+proto';
  return { status: 200, contentType, body: Buffer.concat([head, message]) };
}

// Numbers of a field of float32 in a message.
export function floatsOf(base64) {
  const bytes = Buffer.from(base64 ?? '', 'base64');
  return Array.from({ length: bytes.length / 4 }, (_, i) => bytes.readFloatLE(4 * i));
}

/**
 * Frames of a clip: names of its markers, bones, frame rate, and `frames`, the marker positions of
 * each as one list of x, y, z. `part`: firstFrame, frameCount, stride.
 */
export async function motionOf(server, clip, part = {}) {
  const messages = await stream(server, 'ViewService/ReadClipMotion', { name: clip, ...part });
  const [{ figure, frameRateHz }] = messages;
  const size = 3 * figure.markerNames.length;
  const values = messages.flatMap((message) => floatsOf(message.markerPositions));
  const frames = Array.from({ length: values.length / size }, (_, i) =>
    values.slice(size * i, size * (i + 1)),
  );
  return { names: figure.markerNames, bones: figure.markerBones, frameRateHz, frames };
}

// The marker positions of one frame of a clip, as [name, x, y, z].
export async function markersAt(server, clip, frame) {
  const { names, frames } = await motionOf(server, clip, { firstFrame: frame, frameCount: 1 });
  return names.map((name, index) => [name, ...frames[0].slice(3 * index, 3 * index + 3)]);
}
