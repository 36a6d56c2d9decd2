import { expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { observeClip, observeFiles } from './observed_motion';

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
