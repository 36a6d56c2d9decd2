import { describe, expect, it } from 'vitest';
import { cutMotion, frameCountOf, lastSecondOf, meanMarkerError, poseAt } from './marker_error';

const motion = {
  frameRateHz: 10,
  markerCount: 2,
  positions: Float32Array.of(0, 0, 0, 1, 1, 1, 2, 0, 0, 1, 1, 3, 4, 0, 0, NaN, NaN, NaN),
};

describe('poseAt', () => {
  it('is linear between frames and exact on them', () => {
    expect([...poseAt(motion, 0.1)!]).toEqual([2, 0, 0, 1, 1, 3]);
    const between = poseAt(motion, 0.05)!;
    expect(between[0]).toBeCloseTo(1);
    expect(between[5]).toBeCloseTo(2);
    expect(poseAt(motion, 0.2)![0]).toBe(4);
  });

  it('is undefined outside the motion', () => {
    expect(poseAt(motion, -0.1)).toBeUndefined();
    expect(poseAt(motion, 0.21)).toBeUndefined();
    expect(lastSecondOf(motion)).toBeCloseTo(0.2);
  });
});

describe('meanMarkerError', () => {
  it('is zero for equal poses and the length of a shift', () => {
    const pose = poseAt(motion, 0)!;
    expect(meanMarkerError(pose, pose)).toBe(0);
    expect(
      meanMarkerError(
        pose,
        pose.map((v, i) => v + (i % 3 === 2 ? 0.5 : 0)),
      ),
    ).toBeCloseTo(0.5);
  });

  it('leaves out missing markers', () => {
    expect(meanMarkerError(poseAt(motion, 0.2)!, Float32Array.of(4, 0, 2, 9, 9, 9))).toBe(2);
    expect(meanMarkerError(Float32Array.of(NaN, 0, 0), Float32Array.of(0, 0, 0))).toBeUndefined();
  });
});

describe('cutMotion', () => {
  it('keeps the frames of a range', () => {
    expect([...cutMotion(motion, 0.1, 0.1).positions]).toEqual([2, 0, 0, 1, 1, 3]);
    expect(frameCountOf(cutMotion(motion, 0, 9))).toBe(3);
  });
});
