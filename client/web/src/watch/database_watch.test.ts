import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { watchDatabase } from './database_watch';
import { pause } from './pause';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

// Streams that stay open until they are aborted, or fail immediately.
function apiOf(failure?: Code) {
  let streams = 0;
  const databases = {
    getDatabase: () => Promise.resolve({ database: { revision: 7n } }),
    // eslint-disable-next-line require-yield
    async *watchDatabase(_request: unknown, { signal }: { signal: AbortSignal }) {
      ++streams;
      if (failure !== undefined) throw new ConnectError('failed', failure);
      await new Promise((_resolve, reject) => {
        signal.addEventListener('abort', () => {
          reject(new ConnectError('aborted', Code.Canceled));
        });
      });
    },
  };
  return { api: { databases } as unknown as Api, streams: () => streams };
}

function watch(api: Api, signal: AbortSignal) {
  const state = { ended: false, failures: 0 };
  void watchDatabase(api, {
    database: 'demo',
    signal,
    failed: () => ++state.failures,
    changed: () => undefined,
  }).then(() => {
    state.ended = true;
  });
  return state;
}

test('the watch of a closed view ends without a timer', async () => {
  const { api, streams } = apiOf();
  const closing = new AbortController();
  const state = watch(api, closing.signal);
  await vi.advanceTimersByTimeAsync(1);
  expect(streams()).toBe(1);
  closing.abort();
  await vi.advanceTimersByTimeAsync(0);
  expect(state).toEqual({ ended: true, failures: 0 });
  expect(vi.getTimerCount()).toBe(0);
});

test('a lost watch is tried again, until the view closes in the pause', async () => {
  const { api, streams } = apiOf(Code.Unavailable);
  const closing = new AbortController();
  const state = watch(api, closing.signal);
  await vi.advanceTimersByTimeAsync(2500);
  expect(streams()).toBe(2);
  closing.abort();
  await vi.advanceTimersByTimeAsync(0);
  expect(state).toEqual({ ended: true, failures: 2 });
  expect(vi.getTimerCount()).toBe(0);
});

test('a pause with an aborted signal ends', async () => {
  await pause(1000, AbortSignal.abort());
  expect(vi.getTimerCount()).toBe(0);
});
