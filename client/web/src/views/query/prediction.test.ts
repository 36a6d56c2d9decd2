import { describe, expect, it } from 'vitest';
import { floatBytes, createMotion } from '../../motion/motion';
import type { Figure } from '../../api/messages';
import { centred, comparePoses } from './prediction';

const figure = { markerNames: ['a', 'b'], markerBones: [], jointNames: [], jointBones: [] };
const motion = createMotion('m', figure as unknown as Figure, 10, 3, false, false);
motion.markers.positions.set([0, 0, 0, 1, 0, 0, 1, 0, 0, 2, 0, 0, 2, 0, 0, 3, 0, 0]);
const observed = { name: 'm', motion, legLengthM: undefined };

describe('comparePoses', () => {
  const horizon = (seconds: number, ...values: number[]) => ({
    seconds,
    markerPositions: floatBytes(Float32Array.from(values)),
    extrapolated: false,
    expectedErrorM: 0.1,
  });
  const poses = comparePoses(observed, {
    atSeconds: 0.1,
    horizons: [horizon(0.1, 2, 0, 0, 3, 0, 0.5), horizon(0.5, 2, 0, 0, 3, 0, 0)] as never,
  });

  it('measures the error where the observation goes on', () => {
    expect(poses[0]!.actualErrorM).toBeCloseTo(0.25);
    expect(poses[0]!.expectedErrorM).toBe(0.1);
  });

  it('has no error beyond the end of the observation', () => {
    expect(poses[1]!.observed).toBeUndefined();
    expect(poses[1]!.actualErrorM).toBeUndefined();
  });
});

describe('centred', () => {
  it('puts the middle of the markers above the origin and keeps heights', () => {
    const pose = Float32Array.of(1, 2, 3, 3, 6, 5, NaN, NaN, NaN);
    expect([...centred(pose)].slice(0, 6)).toEqual([-1, -2, 3, 1, 2, 5]);
  });

  it('keeps the distance of two poses with the same reference', () => {
    const pose = Float32Array.of(1, 2, 3);
    expect([...centred(Float32Array.of(2, 2, 3), pose)]).toEqual([1, 0, 3]);
  });
});
