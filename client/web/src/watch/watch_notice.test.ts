import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { Connection } from '../api/connection';
import { watchDatabase, WatchNotice } from './database_watch';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

// A watch whose streams end with these errors, one after the other; then one stays open.
function watchOf(...codes: Code[]) {
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

const text = 'Changes of others are not shown: from the test';

test('a watch that fails shows why, until it works again', async () => {
  const { shown, notice, closing } = watchOf(Code.ResourceExhausted, Code.ResourceExhausted);
  await vi.advanceTimersByTimeAsync(100);
  expect(shown()).toBe(text);
  const line = notice.node.firstChild;
  await vi.advanceTimersByTimeAsync(2000);
  // Screen readers do not say the same again.
  expect(notice.node.firstChild).toBe(line);
  await vi.advanceTimersByTimeAsync(2000);
  expect(shown()).toBe('');
  closing.abort();
});

test('a watch without permission shows why, and stays so', async () => {
  const { shown, closing } = watchOf(Code.PermissionDenied);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(shown()).toBe(text);
  closing.abort();
});

test('a lost connection and a login are shown elsewhere', async () => {
  for (const [code, state] of [
    [Code.Unavailable, 'lost'],
    [Code.Unauthenticated, 'login'],
  ] as const) {
    const { shown, connection, closing } = watchOf(Code.ResourceExhausted, code);
    await vi.advanceTimersByTimeAsync(2100);
    expect([connection.state, shown()]).toEqual([state, '']);
    closing.abort();
  }
});
