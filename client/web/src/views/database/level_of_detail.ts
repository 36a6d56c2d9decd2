import type { MapNodes, MapTransitions } from './state_map';
import type { Matrix } from './projection';

// Nodes drawn as ellipsoids; all others are points.
export const kEllipsoidBudget = 3000;
// Transitions drawn as edges.
export const kEdgeBudget = 6000;

// Indices of the at most `budget` nodes that look largest: the nearest and the longest, inside the
// view. In ascending order. One pass over the nodes and one selection: linear time.
export function largestNodes(
  nodes: MapNodes,
  matrix: Matrix,
  budget = kEllipsoidBudget,
): Int32Array {
  const m = Array.from(matrix);
  const count = nodes.ids.length;
  const sizes = new Float32Array(count);
  for (let i = 0; i < count; ++i) {
    const x = nodes.means[3 * i]!;
    const y = nodes.means[3 * i + 1]!;
    const z = nodes.means[3 * i + 2]!;
    const w = m[3]! * x + m[7]! * y + m[11]! * z + m[15]!;
    if (w <= 0) continue;
    const inside =
      Math.abs(m[0]! * x + m[4]! * y + m[8]! * z + m[12]!) <= 1.2 * w &&
      Math.abs(m[1]! * x + m[5]! * y + m[9]! * z + m[13]!) <= 1.2 * w;
    if (inside) sizes[i] = semiAxisLength(nodes, i) / w;
  }
  return indicesOfLargest(sizes, budget);
}

// Indices of at most `budget` transitions between different nodes with at least the probability
// `least`, the most probable of them, in ascending order.
export function strongestTransitions(
  transitions: MapTransitions,
  least = 0,
  budget = kEdgeBudget,
): Int32Array {
  const { from, to, probabilities } = transitions;
  const strengths = new Float32Array(from.length);
  for (let i = 0; i < from.length; ++i) {
    const drawn = from[i] !== to[i] && from[i]! >= 0 && to[i]! >= 0;
    if (drawn && probabilities[i]! >= least) strengths[i] = probabilities[i]!;
  }
  return indicesOfLargest(strengths, budget);
}

// Length of the longest semi-axis of a node.
export function semiAxisLength(nodes: MapNodes, node: number): number {
  const at = 9 * node;
  return Math.hypot(nodes.semiAxes[at]!, nodes.semiAxes[at + 1]!, nodes.semiAxes[at + 2]!);
}

// Indices of the `budget` largest positive values, ascending; of equal values, the first ones.
export function indicesOfLargest(values: Float32Array, budget: number): Int32Array {
  let positive = 0;
  for (const value of values) if (value > 0) ++positive;
  const count = Math.min(positive, budget);
  const indices = new Int32Array(count);
  if (count === 0) return indices;
  const threshold =
    positive > budget ? Float32Array.from(values).sort()[values.length - budget]! : 0;
  let equalsLeft = count;
  if (threshold > 0) for (const value of values) if (value > threshold) --equalsLeft;
  let at = 0;
  for (let i = 0; i < values.length && at < count; ++i) {
    const value = values[i]!;
    if (value > threshold) indices[at++] = i;
    else if (value === threshold && threshold > 0 && equalsLeft-- > 0) indices[at++] = i;
  }
  return indices;
}
