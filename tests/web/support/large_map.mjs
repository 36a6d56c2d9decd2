// A response of ReadStateMap with many nodes, as Connect sends it in binary format.

function varint(value) {
  const bytes = [];
  for (let rest = value; ; rest = Math.floor(rest / 128)) {
    if (rest < 128) return Buffer.from([...bytes, rest]);
    bytes.push((rest % 128) + 128);
  }
}

const bytes = (field, value) => Buffer.concat([varint(field * 8 + 2), varint(value.length), value]);
const number = (field, value) => Buffer.concat([varint(field * 8), varint(value)]);
const integers = (field, values) => bytes(field, Buffer.concat(values.map(varint)));
const floats = (field, values) => bytes(field, Buffer.from(Float32Array.from(values).buffer));

function envelope(flags, message) {
  const head = Buffer.alloc(5);
  head[0] = flags;
  head.writeUInt32BE(message.length, 1);
  return Buffer.concat([head, message]);
}

// Nodes on a spiral, with one transition from each to the next.
export function largeMap(count) {
  const ids = Array.from({ length: count }, (_, i) => i);
  const header = Buffer.concat([
    number(1, 1),
    number(2, 4),
    integers(3, [1, 2, 4, count]),
    bytes(5, Buffer.from('databases/demo/clips/01_01')),
    bytes(6, Buffer.from('jump')),
    number(7, count),
    number(8, count - 1),
    number(9, 0),
  ]);
  const place = (i) => {
    const turn = i * 0.01;
    const radius = 1 + (9 * i) / count;
    return [radius * Math.cos(turn), radius * Math.sin(turn), Math.sin(i * 0.37) * 3];
  };
  const nodes = Buffer.concat([
    integers(1, ids),
    integers(
      2,
      ids.map((id) => id >> 1),
    ),
    integers(
      3,
      ids.map((id) => 16 + (id % 50)),
    ),
    integers(
      4,
      ids.map(() => 0),
    ),
    floats(
      5,
      ids.map(() => 1),
    ),
    floats(6, ids.flatMap(place)),
    floats(
      7,
      ids.flatMap((id) => [0.1 + (id % 9) / 90, 0, 0, 0, 0.05, 0, 0, 0, 0.02]),
    ),
  ]);
  const transitions = Buffer.concat([
    integers(1, ids.slice(0, -1)),
    integers(2, ids.slice(1)),
    floats(
      3,
      ids.slice(1).map((id) => (1 + (id % 100)) / 101),
    ),
  ]);
  return Buffer.concat([
    envelope(0, bytes(1, header)),
    envelope(0, bytes(2, nodes)),
    envelope(0, bytes(3, transitions)),
    envelope(2, Buffer.from('{}')),
  ]);
}
