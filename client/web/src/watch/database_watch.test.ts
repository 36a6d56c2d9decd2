import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { Connection } from '../api/connection';
import { watchDatabase, WatchNotice } from './database_watch';
import { pause } from './waiting';
import { setHidden } from './test_visibility';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

// Streams that send one change and stay open until they are aborted, or fail immediately.
function apiOf(failure?: Code) {
  let streams = 0;
  let open = 0;
  const revisions: bigint[] = [];
  const databases = {
    getDatabase: () => Promise.resolve({ database: { revision: 7n } }),
    async *watchDatabase(
      { afterRevision }: { afterRevision: bigint },
      { signal }: { signal: AbortSignal },
    ) {
      ++streams;
      revisions.push(afterRevision);
      if (failure !== undefined) throw new ConnectError('failed', failure);
      if (signal.aborted) throw new ConnectError('aborted', Code.Canceled);
      yield { change: { case: 'deleted' }, revision: afterRevision + 1n, upToDate: true };
      ++open;
      await new Promise((_resolve, reject) => {
        signal.addEventListener('abort', () => {
          --open;
          reject(new ConnectError('aborted', Code.Canceled));
        });
      });
    },
  };
  return {
    api: { databases } as unknown as Api,
    streams: () => streams,
    open: () => open,
    revisions,
  };
}

function watch(api: Api, signal: AbortSignal) {
  const state = { ended: false, failures: 0, changes: 0 };
  void watchDatabase(api, {
    database: 'demo',
    signal,
    observer: { works: vi.fn(), failed: () => ++state.failures },
    changed: () => ++state.changes,
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
  // The beginning, and the change.
  expect(state).toEqual({ ended: true, failures: 0, changes: 2 });
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
  expect(state).toEqual({ ended: true, failures: 2, changes: 1 });
  expect(vi.getTimerCount()).toBe(0);
});

test('the watch ends while the page is hidden, and then continues where it was', async () => {
  const { api, open, revisions } = apiOf();
  const closing = new AbortController();
  const state = watch(api, closing.signal);
  await vi.advanceTimersByTimeAsync(0);
  expect(open()).toBe(1);
  setHidden(true);
  await vi.advanceTimersByTimeAsync(60_000);
  expect([open(), state.changes, state.failures]).toEqual([0, 2, 0]);
  setHidden(false);
  await vi.advanceTimersByTimeAsync(0);
  expect([open(), state.changes]).toEqual([1, 3]);
  expect(revisions).toEqual([7n, 8n]);
  closing.abort();
  await vi.advanceTimersByTimeAsync(0);
  expect(state).toEqual({ ended: true, failures: 0, changes: 3 });
});

test('a page that opens hidden watches from then on, when it is visible', async () => {
  setHidden(true);
  const { api, streams, revisions } = apiOf();
  const closing = new AbortController();
  const state = watch(api, closing.signal);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(streams()).toBe(0);
  setHidden(false);
  await vi.advanceTimersByTimeAsync(0);
  expect(revisions).toEqual([7n]);
  setHidden(true);
  closing.abort();
  await vi.advanceTimersByTimeAsync(0);
  expect(state.ended).toBe(true);
});

test('a closed view leaves no listener of the hidden page', async () => {
  const added = vi.spyOn(document, 'addEventListener');
  const removed = vi.spyOn(document, 'removeEventListener');
  setHidden(true);
  const { api, streams } = apiOf();
  const closing = new AbortController();
  const state = watch(api, closing.signal);
  await vi.advanceTimersByTimeAsync(0);
  closing.abort();
  await vi.advanceTimersByTimeAsync(0);
  expect([state.ended, state.failures, streams()]).toEqual([true, 0, 1]);
  expect(added.mock.calls.length).toBeGreaterThan(0);
  const left = added.mock.calls.filter(
    ([, listener]) => !removed.mock.calls.some(([, gone]) => gone === listener),
  );
  expect(left).toEqual([]);
});

test('changes that the server has forgotten are reported as no changes', async () => {
  // The last one: the database was restored from a backup and has a lower revision.
  for (const code of [Code.OutOfRange, Code.FailedPrecondition, Code.InvalidArgument]) {
    const { api, revisions } = apiOf(code);
    const closing = new AbortController();
    const state = watch(api, closing.signal);
    await vi.advanceTimersByTimeAsync(1);
    expect([state.changes, revisions.length]).toEqual([1, 1]);
    await vi.advanceTimersByTimeAsync(2000);
    expect([state.changes, revisions.length]).toEqual([2, 2]);
    closing.abort();
    await vi.advanceTimersByTimeAsync(0);
  }
});

// The notice of a watch whose streams end with these errors, one after the other; then one stays
// open.
function noticeOf(...codes: Code[]) {
  const closing = new AbortController();
  const connection = new Connection(() => new Promise(() => undefined));
  const notice = new WatchNotice(connection);
  const databases = {
    getDatabase: () => Promise.resolve({ database: { revision: 7n } }),
    async *watchDatabase() {
      const code = codes.shift();
      if (code !== undefined) throw new ConnectError('from the test', code);
      yield { change: {}, revision: 7n, upToDate: true };
      await new Promise((_resolve, reject) => {
        closing.signal.addEventListener('abort', reject);
      });
    },
  };
  void watchDatabase({ databases } as unknown as Api, {
    database: 'demo',
    signal: closing.signal,
    observer: notice,
    changed: vi.fn(),
  });
  const shown = () => (notice.node.hidden ? '' : notice.node.textContent);
  return { shown, notice, connection, closing };
}

const kFailed = 'Changes of others are not shown: from the test';

test('a watch that fails shows why, until it works again', async () => {
  const { shown, notice, closing } = noticeOf(Code.ResourceExhausted, Code.ResourceExhausted);
  await vi.advanceTimersByTimeAsync(100);
  expect(shown()).toBe(kFailed);
  const line = notice.node.firstChild;
  await vi.advanceTimersByTimeAsync(2000);
  // Screen readers do not say the same again.
  expect(notice.node.firstChild).toBe(line);
  await vi.advanceTimersByTimeAsync(2000);
  expect(shown()).toBe('');
  closing.abort();
});

test('a watch without permission shows why, and stays so', async () => {
  const { shown, closing } = noticeOf(Code.PermissionDenied);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(shown()).toBe(kFailed);
  closing.abort();
});

test('a lost connection and a login are shown elsewhere', async () => {
  for (const [code, state] of [
    [Code.Unavailable, 'lost'],
    [Code.Unauthenticated, 'login'],
  ] as const) {
    const { shown, connection, closing } = noticeOf(Code.ResourceExhausted, code);
    await vi.advanceTimersByTimeAsync(2100);
    expect([connection.state, shown()]).toEqual([state, '']);
    closing.abort();
  }
});

test('a pause with an aborted signal ends', async () => {
  await pause(1000, AbortSignal.abort());
  expect(vi.getTimerCount()).toBe(0);
});
