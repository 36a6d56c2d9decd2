import { create } from '@bufbuild/protobuf';
import { createClient, createRouterTransport } from '@connectrpc/connect';
import { expect, test } from 'vitest';
import type { Api } from '../api/api';
import { FigureSchema, ViewService } from '../api/messages';
import { MotionCache } from './motion_reader';

const kFrames = 1000;
const kBytes = kFrames * 2 * 3 * 4;

function cacheOf(limitBytes: number, truncated = false) {
  let calls = 0;
  const transport = createRouterTransport(({ service }) => {
    service(ViewService, {
      async *readClipMotion() {
        ++calls;
        const figure = create(FigureSchema, { markerNames: ['a', 'b'] });
        yield {
          figure,
          frameRateHz: 60,
          clipFrameCount: kFrames,
          frameCount: 600,
          markerPositions: new Uint8Array((kBytes * 600) / kFrames),
        };
        if (truncated) return;
        yield {
          firstFrame: 600,
          frameCount: 400,
          markerPositions: new Uint8Array((kBytes * 400) / kFrames),
        };
        await Promise.resolve();
      },
    });
  });
  const api = { views: createClient(ViewService, transport) } as unknown as Api;
  return { cache: new MotionCache(api, limitBytes), calls: () => calls };
}

const ignore = () => undefined;
const { signal } = new AbortController();

test('memory stays bounded while clips are browsed', async () => {
  const { cache, calls } = cacheOf(10 * kBytes);
  for (let clip = 0; clip < 200; ++clip) {
    await cache.load(`clip${clip}`, '1', signal, ignore);
    expect(cache.byteCount).toBeLessThanOrEqual(10 * kBytes);
  }
  expect(calls()).toBe(200);
  await cache.load('clip199', '1', signal, ignore);
  expect(calls()).toBe(200);
  await cache.load('clip199', 'changed', signal, ignore);
  await cache.load('clip0', '1', signal, ignore);
  expect(calls()).toBe(202);
});

test('a motion that ends early is an error and is not kept', async () => {
  const { cache } = cacheOf(10 * kBytes, true);
  await expect(cache.load('clip', '1', signal, ignore)).rejects.toThrow(
    'Expected 1000 frames, got 600',
  );
  expect(cache.byteCount).toBe(0);
});
