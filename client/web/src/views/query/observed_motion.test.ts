import { expect, test, vi, describe, it } from 'vitest';
import type { Api } from '../../api/api';
import {
  observeClip,
  observeFiles,
  cutMotion,
  frameCountOf,
  lastSecondOf,
  meanMarkerError,
  poseAt,
} from './observed_motion';

test('a motion that is larger than any request is not read', async () => {
  const arrayBuffer = vi.fn();
  const file = { name: 'walk.bvh', size: 2 ** 31, arrayBuffer } as unknown as File;
  const asked = observeFiles({} as Api, 'demo', [file], new AbortController().signal);
  await expect(asked).rejects.toThrow('walk.bvh: expected at most 1,024 MiB');
  expect(arrayBuffer).not.toHaveBeenCalled();
});

test('a clip that a shorter one replaces between two calls is not asked about', async () => {
  let frames = 10;
  async function* readClipMotion() {
    await Promise.resolve();
    const figure = { markerNames: ['a'], markerBones: [] };
    const markerPositions = new Uint8Array(12 * frames);
    yield { figure, frameRateHz: 60, firstFrame: 0, frameCount: frames, markerPositions };
  }
  const clip = { frameCount: 10, durationSeconds: 10 / 60 };
  const api = { clips: { getClip: () => Promise.resolve({ clip }) }, views: { readClipMotion } };
  const observe = () =>
    observeClip(
      api as unknown as Api,
      'demo',
      'walk',
      undefined,
      undefined,
      new AbortController().signal,
    );
  expect((await observe()).motion.receivedFrames).toBe(10);
  frames = 7;
  await expect(observe()).rejects.toThrow('Expected 10 frames, got 7.');
});

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
