// Axes of a picture: all three in perspective, or a plane of two.
export type Axes = '123' | '12' | '13' | '23';

export const kAllAxes: readonly Axes[] = ['123', '12', '13', '23'];

// A 4 x 4 matrix in column order, like `THREE.Matrix4.elements`.
export type Matrix = ArrayLike<number>;

// Direction from which a plane is seen, and the direction that is up in it.
export function viewOf(axes: Axes): {
  from: [number, number, number];
  up: [number, number, number];
} {
  switch (axes) {
    case '12':
      return { from: [0, 0, 1], up: [0, 1, 0] };
    case '13':
      return { from: [0, -1, 0], up: [0, 0, 1] };
    case '23':
      return { from: [1, 0, 0], up: [0, 0, 1] };
    case '123':
      return { from: [0.6, -0.9, 0.55], up: [0, 0, 1] };
  }
}

// Screen positions of points, 3 values for each: x and y in px from the top left, and the depth,
// -1 (near) to 1 (far). A point behind the camera has NaN.
export function projectPoints(
  positions: Float32Array,
  matrix: Matrix,
  width: number,
  height: number,
  out = new Float32Array(positions.length),
): Float32Array {
  const m = Array.from(matrix);
  for (let i = 0; i + 2 < positions.length; i += 3) {
    const x = positions[i]!;
    const y = positions[i + 1]!;
    const z = positions[i + 2]!;
    const w = m[3]! * x + m[7]! * y + m[11]! * z + m[15]!;
    if (w <= 0) {
      out[i] = out[i + 1] = out[i + 2] = NaN;
      continue;
    }
    out[i] = (((m[0]! * x + m[4]! * y + m[8]! * z + m[12]!) / w + 1) * width) / 2;
    out[i + 1] = ((1 - (m[1]! * x + m[5]! * y + m[9]! * z + m[13]!) / w) * height) / 2;
    out[i + 2] = (m[2]! * x + m[6]! * y + m[10]! * z + m[14]!) / w;
  }
  return out;
}

// Parallel projection without WebGL: `zoom` 1 shows the sphere of `radius` around `centre`.
export function parallelMatrix(
  axes: Axes,
  centre: readonly number[],
  radius: number,
  width: number,
  height: number,
  zoom = 1,
): number[] {
  const { from, up } = viewOf(axes);
  const back = scaled(from, 1 / Math.hypot(...from));
  const right = cross(up, back);
  const unitRight = scaled(right, 1 / Math.hypot(...right));
  const unitUp = cross(back, unitRight);
  const scale = (zoom * Math.min(width, height)) / Math.max(radius, 1e-9);
  const rows = [
    scaled(unitRight, scale / width),
    scaled(unitUp, scale / height),
    scaled(back, -1 / Math.max(radius, 1e-9)),
  ];
  const shift = rows.map((row) => -dot(row, centre));
  return [0, 1, 2].flatMap((column) => [...rows.map((row) => row[column]!), 0]).concat(shift, 1);
}

// Index of the shown point (1 in `shown`) nearest to (x, y) within `reach` px, the front one of equals;
// -1: none.
export function pick(
  projected: Float32Array,
  shown: Uint8Array,
  x: number,
  y: number,
  reach: number,
): number {
  let best = -1;
  let bestDistance = reach;
  let bestDepth = Infinity;
  for (let i = 0; i + 2 < projected.length; i += 3) {
    const depth = projected[i + 2]!;
    if (shown[i / 3] !== 1 || !(depth >= -1 && depth <= 1)) continue;
    const distance = Math.hypot(projected[i]! - x, projected[i + 1]! - y);
    if (distance < bestDistance || (distance === bestDistance && depth < bestDepth)) {
      best = i / 3;
      bestDistance = distance;
      bestDepth = depth;
    }
  }
  return best;
}

function cross(a: readonly number[], b: readonly number[]): number[] {
  return [
    a[1]! * b[2]! - a[2]! * b[1]!,
    a[2]! * b[0]! - a[0]! * b[2]!,
    a[0]! * b[1]! - a[1]! * b[0]!,
  ];
}

function dot(a: readonly number[], b: readonly number[]): number {
  return a.reduce((sum, value, i) => sum + value * b[i]!, 0);
}

function scaled(a: readonly number[], factor: number): number[] {
  return a.map((value) => value * factor);
}
