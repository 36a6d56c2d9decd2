import {
  BufferAttribute,
  BufferGeometry,
  Color,
  CylinderGeometry,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  MeshBasicMaterial,
  type MeshLambertMaterial,
  Points,
  PointsMaterial,
  Quaternion,
  SRGBColorSpace,
  Vector3,
} from 'three';
import type { MapNodes } from './state_map';

export type Ellipsoids = InstancedMesh<IcosahedronGeometry, MeshLambertMaterial>;
export type Edges = InstancedMesh<CylinderGeometry, MeshBasicMaterial>;

const kUp = new Vector3(0, 1, 0);

// Shown positions as dots of a size in px: one draw call. Their order is spread over all places, so
// that the first ones are a sample. Colours are sRGB.
export function createDots(
  positions: Float32Array,
  colors: Float32Array,
  shown: Uint8Array,
  size: number,
): Points<BufferGeometry, PointsMaterial> {
  const count = shown.reduce((sum, value) => sum + value, 0);
  const places = new Float32Array(3 * count);
  const linear = new Float32Array(3 * count);
  const color = new Color();
  let at = 0;
  spreadOrder(shown.length, (i) => {
    if (shown[i] === 0) return;
    places.set(positions.subarray(3 * i, 3 * i + 3), at);
    color.setRGB(colors[3 * i]!, colors[3 * i + 1]!, colors[3 * i + 2]!, SRGBColorSpace);
    color.toArray(linear, at);
    at += 3;
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(places, 3));
  geometry.setAttribute('color', new BufferAttribute(linear, 3));
  const material = new PointsMaterial({ size, sizeAttenuation: false, vertexColors: true });
  const dots = new Points(geometry, material);
  dots.frustumCulled = false;
  return dots;
}

// Room for `budget` ellipsoids in one draw call. The material can be shared.
export function createEllipsoids(budget: number, material: MeshLambertMaterial): Ellipsoids {
  const mesh = new InstancedMesh(new IcosahedronGeometry(1, 1), material, Math.max(1, budget));
  mesh.frustumCulled = false;
  mesh.count = 0;
  return mesh;
}

// Puts an ellipsoid at a place of the mesh. Semi-axes are scaled by `size`, and never thinner than
// `least`, so that a flat distribution stays visible.
export function setEllipsoid(
  mesh: Ellipsoids,
  place: number,
  nodes: MapNodes,
  node: number,
  size: number,
  least: number,
): void {
  const axes = [0, 1, 2].map((row) =>
    new Vector3().fromArray(nodes.semiAxes, 9 * node + 3 * row).multiplyScalar(size),
  );
  const lengths = axes.map((axis) => Math.max(axis.length(), least));
  const first = axes[0]!.lengthSq() > 0 ? axes[0]!.normalize() : new Vector3(1, 0, 0);
  const second = axes[1]!.addScaledVector(first, -axes[1]!.dot(first));
  if (second.lengthSq() < 1e-12) second.crossVectors(first, leastAligned(first));
  second.normalize();
  const third = new Vector3().crossVectors(first, second);
  const matrix = new Matrix4().makeBasis(
    first.clone().multiplyScalar(lengths[0]!),
    second.clone().multiplyScalar(lengths[1]!),
    third.multiplyScalar(lengths[2]!),
  );
  matrix.setPosition(new Vector3().fromArray(nodes.means, 3 * node));
  mesh.setMatrixAt(place, matrix);
}

// Edges as thin cylinders in one draw call. `edges` are (from, to, radius).
export function createEdges(
  positions: Float32Array,
  edges: readonly (readonly [from: number, to: number, radius: number])[],
  color: string,
  opacity: number,
): Edges {
  const material = new MeshBasicMaterial({ color, transparent: opacity < 1, opacity });
  const geometry = new CylinderGeometry(1, 1, 1, 5, 1, true);
  const mesh = new InstancedMesh(geometry, material, Math.max(1, edges.length));
  mesh.frustumCulled = false;
  mesh.count = edges.length;
  const matrix = new Matrix4();
  const turn = new Quaternion();
  edges.forEach(([start, end, radius], i) => {
    const from = new Vector3().fromArray(positions, 3 * start);
    const along = new Vector3().fromArray(positions, 3 * end).sub(from);
    const length = along.length();
    if (length > 0) turn.setFromUnitVectors(kUp, along.clone().divideScalar(length));
    matrix.compose(from.addScaledVector(along, 0.5), turn, new Vector3(radius, length, radius));
    mesh.setMatrixAt(i, matrix);
  });
  return mesh;
}

// Calls back with each index below `count` once, in steps that spread them.
export function spreadOrder(count: number, call: (index: number) => void): void {
  let step = Math.max(1, Math.floor(count * 0.618));
  const divisor = (a: number, b: number): number => (b === 0 ? a : divisor(b, a % b));
  while (divisor(count, step) > 1) ++step;
  for (let i = 0, index = 0; i < count; ++i, index = (index + step) % count) call(index);
}

function leastAligned(axis: Vector3): Vector3 {
  return Math.abs(axis.x) < 0.6 ? new Vector3(1, 0, 0) : new Vector3(0, 1, 0);
}
