import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Disposer } from '../../dom/disposer';
import { recordRectangles } from '../../drawing/test_canvas';
import type { ViewContext } from '../../shell/view';
import { setHidden } from '../../watch/test_visibility';
import { StreamWatch } from './stream_watch';

vi.mock('../../chart/line_chart', () => ({
  LineChart: class {
    node = document.createElement('figure');
    setData = vi.fn();
    dispose = vi.fn();
  },
}));
vi.mock('./live_stage', () => ({}));

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

test('the ribbon is empty for the time in which the page was hidden', async () => {
  const started = Date.now();
  // An answer each half second.
  async function* watchStream(_request: unknown, { signal }: { signal: AbortSignal }) {
    for (;;) {
      await new Promise((resolve) => setTimeout(resolve, 500));
      signal.throwIfAborted();
      const frame = (60 * (Date.now() - started)) / 1000;
      const labels = [{ label: 'walk', probability: 1 }];
      const answer = { frame: BigInt(Math.round(frame)), labels, horizons: [], familiarity: 1 };
      const stream = { frameRateHz: 60 };
      yield { stream, answer, skippedCount: 0n, latencySeconds: 0 };
    }
  }
  const api = { observe: { watchStream }, views: { getFigure: () => Promise.resolve({}) } };
  const theme = { onChange: () => () => undefined, color: (name: string) => name };
  const drawn = recordRectangles();
  const disposer = new Disposer();
  const context = { api, theme } as unknown as ViewContext;
  void new StreamWatch(context, 'demo', 's', disposer).run();
  await vi.advanceTimersByTimeAsync(2100);
  expect(drawn.length).toBe(4);
  setHidden(true);
  await vi.advanceTimersByTimeAsync(6000);
  setHidden(false);
  await vi.advanceTimersByTimeAsync(1100);
  // 1200 px are 20 s: answers at 0.5, 1, 1.5, 2, and after the gap at 8.6 and 9.1 s.
  const seconds = drawn.map(({ x, width }) => [(x - 1200) / 60 + 9.1, width / 60]);
  const expected = [0.5, 1, 1.5, 2, 8.6, 9.1].map((time) => [
    time,
    time === 2 || time === 9.1 ? 0.05 : 0.5,
  ]);
  expect(seconds.length).toBe(expected.length);
  seconds.forEach((values, i) => {
    values.forEach((value, k) => {
      expect(value).toBeCloseTo(expected[i]![k]!, 5);
    });
  });
  disposer.dispose();
});
