import { create } from '@bufbuild/protobuf';
import { afterEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { ClipSchema } from '../../api/messages';
import type { ThemeSwitch } from '../../shell/theme';
import { Thumbnails } from './thumbnail';

afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

test('a clip that is derived again gets a new picture, and another one keeps its picture', async () => {
  vi.stubGlobal(
    'IntersectionObserver',
    class {
      constructor(private readonly seen: (entries: object[]) => void) {}
      observe = (target: Element) => {
        this.seen([{ target, isIntersecting: true }]);
      };
      unobserve = vi.fn();
      disconnect = vi.fn();
    },
  );
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(null);
  const readClipMotion = vi.fn(async function* ({ name }: { name: string }) {
    await Promise.resolve(name);
    const figure = { markerNames: [], markerBones: [] };
    yield { figure, frameCount: 5, firstFrame: 0, markerPositions: new Uint8Array(0) };
  });
  const api = { views: { readClipMotion } } as unknown as Api;
  const theme = { onChange: () => () => undefined, color: () => '' } as unknown as ThemeSwitch;
  const thumbnails = new Thumbnails(api, theme, new AbortController().signal);
  const draw = async (etags: string[]) => {
    thumbnails.clear();
    etags.forEach((etag, i) => {
      const name = `databases/demo/clips/${i}`;
      thumbnails.create(create(ClipSchema, { name, etag, createTime: { seconds: 1n } }));
    });
    await new Promise((resolve) => setTimeout(resolve, 5));
    return readClipMotion.mock.calls.splice(0).map(([{ name }]) => name.slice(-1));
  };
  expect(await draw(['1', '1'])).toEqual(['0', '1']);
  expect(await draw(['1', '1'])).toEqual([]);
  expect(await draw(['1', '2'])).toEqual(['1']);
});
