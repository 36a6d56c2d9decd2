// The bytes of float32 values, little-endian, for a `bytes` field.
export function floatBytes(floats: Float32Array): Uint8Array {
  const bytes = new Uint8Array(4 * floats.length);
  const view = new DataView(bytes.buffer);
  floats.forEach((value, i) => {
    view.setFloat32(4 * i, value, true);
  });
  return bytes;
}
