// Reads animations of GLB files (glTF 2.0 in one file).
import assert from 'node:assert/strict';

/**
 * The JSON of a GLB file and its animations, each as a list of channels: {node, path, times, values},
 * the values of each key as one list.
 */
export function readGlb(bytes) {
  assert.equal(bytes.toString('latin1', 0, 4), 'glTF', 'magic');
  assert.equal(bytes.readUInt32LE(4), 2, 'version');
  assert.equal(bytes.readUInt32LE(8), bytes.length, 'length');
  const chunkAt = (start, kind) => {
    assert.equal(bytes.toString('latin1', start + 4, start + 8), kind);
    return bytes.subarray(start + 8, start + 8 + bytes.readUInt32LE(start));
  };
  const text = chunkAt(12, 'JSON');
  const buffer = chunkAt(20 + text.length, 'BIN\0');
  const json = JSON.parse(text.toString());
  const sizes = { SCALAR: 1, VEC3: 3, VEC4: 4 };
  const read = (index) => {
    const { bufferView, byteOffset = 0, componentType, count, type } = json.accessors[index];
    assert.equal(componentType, 5126, 'float32');
    const begin = (json.bufferViews[bufferView].byteOffset ?? 0) + byteOffset;
    const valueOf = (i) => buffer.readFloatLE(begin + 4 * i);
    return Array.from({ length: count }, (_, key) =>
      Array.from({ length: sizes[type] }, (_, part) => valueOf(key * sizes[type] + part)),
    );
  };
  const animations = json.animations.map(({ channels, samplers }) =>
    channels.map(({ sampler, target }) => ({
      ...target,
      times: read(samplers[sampler].input).flat(),
      values: read(samplers[sampler].output),
    })),
  );
  return { json, animations };
}
