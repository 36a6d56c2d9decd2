import type { PointTrack } from './motion';

export type CurveKind = 'position' | 'height' | 'speed';

export interface Curve {
  name: string;
  color: string;
  values: Float64Array;
}

// Curves of a point over all frames: x, y and z (m), the height alone (m), or the speed (m/s).
// Missing frames are NaN.
export function curvesOf(
  track: PointTrack,
  point: number,
  kind: CurveKind,
  frameRateHz: number,
): Curve[] {
  if (kind === 'speed') {
    return [{ name: 'speed', color: '--accent', values: speedOf(track, point, frameRateHz) }];
  }
  const axes = [
    { name: 'x', color: '--left', axis: 0 },
    { name: 'y', color: '--right', axis: 1 },
    { name: 'z', color: '--trail', axis: 2 },
  ];
  const chosen = kind === 'height' ? axes.slice(2) : axes;
  return chosen.map(({ name, color, axis }) => ({
    name,
    color,
    values: axisOf(track, point, axis),
  }));
}

// The values of curves in a frame, as in `x 0.123, y 0.456, z 1.234 m`.
export function valueText(curves: readonly Curve[], frame: number, unit: string): string {
  const at = curves.map(({ values }) => values[frame] ?? NaN);
  if (at.some((value) => Number.isNaN(value))) return 'missing';
  const texts = curves.map(({ name }, index) => `${name} ${(at[index] ?? NaN).toFixed(3)}`);
  return `${texts.join(', ')} ${unit}`;
}

// Times of the frames, s.
export function frameTimes(frameCount: number, frameRateHz: number): Float64Array {
  return Float64Array.from({ length: frameCount }, (_, frame) => frame / frameRateHz);
}

function frameCountOf(track: PointTrack): number {
  return track.names.length === 0
    ? 0
    : Math.floor(track.positions.length / (3 * track.names.length));
}

function axisOf(track: PointTrack, point: number, axis: number): Float64Array {
  const size = 3 * track.names.length;
  return Float64Array.from(
    { length: frameCountOf(track) },
    (_, frame) => track.positions[frame * size + 3 * point + axis] ?? NaN,
  );
}

// Speed by central differences; at the ends by one-sided ones.
function speedOf(track: PointTrack, point: number, frameRateHz: number): Float64Array {
  const axes = [0, 1, 2].map((axis) => axisOf(track, point, axis));
  const last = frameCountOf(track) - 1;
  return Float64Array.from({ length: last + 1 }, (_, frame) => {
    const before = Math.max(0, frame - 1);
    const after = Math.min(last, frame + 1);
    if (after === before) return 0;
    const steps = axes.map((values) => (values[after] ?? NaN) - (values[before] ?? NaN));
    return (Math.hypot(...steps) * frameRateHz) / (after - before);
  });
}
