import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { serverError } from '../../api/test_server';
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

// What the page reads of a database before the stream.
const kStored = {
  views: { getFigure: () => Promise.resolve({}) },
  databases: { getDatabase: () => Promise.resolve({}) },
};

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
  const api = { observe: { watchStream }, ...kStored };
  const theme = { name: 'light', onChange: () => () => undefined, color: (name: string) => name };
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

// A watch whose calls end with these errors, one after the other.
function watchOf(failures: (Code | ConnectError)[]) {
  const watchStream = vi.fn(() => ({
    [Symbol.asyncIterator]: () => ({
      next: () => {
        const failure = failures.shift();
        return Promise.reject(
          failure instanceof ConnectError ? failure : new ConnectError('from the test', failure),
        );
      },
    }),
  }));
  const failed = vi.fn();
  const api = { observe: { watchStream }, ...kStored };
  const theme = { name: 'light', onChange: () => () => undefined, color: (name: string) => name };
  recordRectangles();
  const disposer = new Disposer();
  const context = { api, theme, connection: { failed } } as unknown as ViewContext;
  const watch = new StreamWatch(context, 'demo', 's', disposer);
  return { watch, watchStream, failed, disposer };
}

test('a stream is watched again after a lost connection, until it does not run any more', async () => {
  const { watch, watchStream, failed } = watchOf([
    Code.Unavailable,
    Code.Unavailable,
    serverError(Code.Unavailable, 'STORE_UNREACHABLE'),
    Code.NotFound,
  ]);
  const done = watch.run();
  await vi.advanceTimersByTimeAsync(60_000);
  await done;
  expect(watchStream).toHaveBeenCalledTimes(4);
  expect(failed).toHaveBeenCalledTimes(3);
  expect(watch.node.textContent).toContain('does not run any more');
});

test('another error of a stream is shown and not tried again', async () => {
  const { watch, watchStream } = watchOf([Code.PermissionDenied]);
  const done = watch.run();
  await vi.advanceTimersByTimeAsync(60_000);
  await done;
  expect(watchStream).toHaveBeenCalledTimes(1);
  expect(watch.node.textContent).toContain('from the test');
});
