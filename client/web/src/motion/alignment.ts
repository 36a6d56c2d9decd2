import type { Motion } from './motion';

const kMaxSamples = 300;
const kMinOverlapFraction = 0.5;

// Seconds by which `other` must be shifted to be most like `motion`: time t of `motion` is then
// t + offset of `other`. Compares the heights of the markers that both have, at most 300 samples
// of each. At least half of the shorter motion overlaps. 0 if the motions have no common markers.
export function alignmentOffset(motion: Motion, other: Motion): number {
  const common = motion.markers.names.filter((name) => other.markers.names.includes(name));
  if (common.length === 0) return 0;
  const longest = Math.max(
    motion.frameCount / motion.frameRateHz,
    other.frameCount / other.frameRateHz,
  );
  const step = Math.max(longest / kMaxSamples, 1 / Math.min(motion.frameRateHz, other.frameRateHz));
  const a = heightsOf(motion, common, step);
  const b = heightsOf(other, common, step);
  const minOverlap = Math.max(1, Math.floor(kMinOverlapFraction * Math.min(a.length, b.length)));
  let best = 0;
  let bestDistance = Infinity;
  for (let shift = minOverlap - a.length; shift <= b.length - minOverlap; ++shift) {
    const distance = distanceAt(a, b, shift);
    if (distance < bestDistance - 1e-12) {
      bestDistance = distance;
      best = shift;
    }
  }
  return best * step;
}

// Mean squared difference of a[i] and b[i + shift] where both exist.
function distanceAt(a: readonly Float32Array[], b: readonly Float32Array[], shift: number): number {
  let sum = 0;
  let count = 0;
  for (let index = Math.max(0, -shift); index < a.length && index + shift < b.length; ++index) {
    const left = a[index];
    const right = b[index + shift];
    if (!left || !right) continue;
    for (let marker = 0; marker < left.length; ++marker) {
      const difference = (left[marker] ?? NaN) - (right[marker] ?? NaN);
      if (Number.isNaN(difference)) continue;
      sum += difference * difference;
      ++count;
    }
  }
  return count === 0 ? Infinity : sum / count;
}

function heightsOf(motion: Motion, names: readonly string[], step: number): Float32Array[] {
  const size = motion.markers.names.length * 3;
  const points = names.map((name) => motion.markers.names.indexOf(name));
  const samples: Float32Array[] = [];
  for (let time = 0; time < motion.frameCount / motion.frameRateHz - 1e-9; time += step) {
    const frame = Math.min(motion.frameCount - 1, Math.round(time * motion.frameRateHz));
    samples.push(
      Float32Array.from(
        points,
        (point) => motion.markers.positions[frame * size + 3 * point + 2] ?? NaN,
      ),
    );
  }
  return samples;
}
