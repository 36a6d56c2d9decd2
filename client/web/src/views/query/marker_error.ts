// Marker positions of a motion: frames x markers x 3, m.
export interface MarkerMotion {
  frameRateHz: number;
  markerCount: number;
  positions: Float32Array;
}

// Number of frames of a motion.
export function frameCountOf(motion: MarkerMotion): number {
  return motion.markerCount > 0 ? motion.positions.length / (3 * motion.markerCount) : 0;
}

// Time of the last frame, s.
export function lastSecondOf(motion: MarkerMotion): number {
  return Math.max(0, frameCountOf(motion) - 1) / motion.frameRateHz;
}

// Pose at a time, linear between frames; undefined outside the motion.
export function poseAt(motion: MarkerMotion, seconds: number): Float32Array | undefined {
  const count = frameCountOf(motion);
  const at = seconds * motion.frameRateHz;
  if (count === 0 || at < -1e-6 || at > count - 1 + 1e-6) return undefined;
  const low = Math.min(Math.max(0, Math.floor(at + 1e-6)), count - 1);
  const part = Math.max(0, at - low);
  const size = 3 * motion.markerCount;
  const first = motion.positions.subarray(low * size, (low + 1) * size);
  if (part < 1e-6 || low + 1 >= count) return first.slice();
  const second = motion.positions.subarray((low + 1) * size, (low + 2) * size);
  return first.map((value, i) => value + part * (second[i]! - value));
}

// Frames [from, to] (s) of a motion as a motion of its own; at least one frame.
export function cutMotion(motion: MarkerMotion, from: number, to: number): MarkerMotion {
  const count = frameCountOf(motion);
  const size = 3 * motion.markerCount;
  const first = Math.min(
    Math.max(0, Math.round(from * motion.frameRateHz)),
    Math.max(0, count - 1),
  );
  const last = Math.min(
    Math.max(first, Math.round(to * motion.frameRateHz)),
    Math.max(0, count - 1),
  );
  return { ...motion, positions: motion.positions.slice(first * size, (last + 1) * size) };
}

// Mean distance of markers that both poses have, m; undefined if they share none.
export function meanMarkerError(a: Float32Array, b: Float32Array): number | undefined {
  let sum = 0;
  let count = 0;
  for (let i = 0; i + 2 < Math.min(a.length, b.length); i += 3) {
    const distance = Math.hypot(a[i]! - b[i]!, a[i + 1]! - b[i + 1]!, a[i + 2]! - b[i + 2]!);
    if (Number.isNaN(distance)) continue;
    sum += distance;
    ++count;
  }
  return count > 0 ? sum / count : undefined;
}
