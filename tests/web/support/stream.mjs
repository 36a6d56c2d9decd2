// Calls that stream responses, without a browser.

// Calls an RPC of the server with Connect's envelopes; returns the messages as JSON.
export async function stream(server, method, request) {
  const message = Buffer.from(JSON.stringify(request));
  const head = Buffer.alloc(5);
  head.writeUInt32BE(message.length, 1);
  const response = await fetch(`${server}/motiondb.v1.${method}`, {
    method: 'POST',
    headers: { 'content-type': 'application/connect+json' },
    body: Buffer.concat([head, message]),
  });
  const bytes = Buffer.from(await response.arrayBuffer());
  const messages = [];
  for (let at = 0; at < bytes.length; ) {
    const size = bytes.readUInt32BE(at + 1);
    const text = bytes.subarray(at + 5, at + 5 + size).toString();
    if (bytes[at] === 0) messages.push(JSON.parse(text));
    else if (JSON.parse(text).error !== undefined) throw new Error(text);
    at += 5 + size;
  }
  return messages;
}

// The marker positions of one frame of a clip, as [name, x, y, z].
export async function markersAt(server, clip, frame) {
  const [first] = await stream(server, 'ViewService/ReadClipMotion', {
    name: clip,
    firstFrame: frame,
    frameCount: 1,
  });
  const bytes = Buffer.from(first.markerPositions, 'base64');
  return first.figure.markerNames.map((name, index) => [
    name,
    bytes.readFloatLE(12 * index),
    bytes.readFloatLE(12 * index + 4),
    bytes.readFloatLE(12 * index + 8),
  ]);
}
