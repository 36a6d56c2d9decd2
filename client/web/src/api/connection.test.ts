import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from './connection';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

test('a lost connection is probed until it is restored', async () => {
  let up = false;
  const probe = vi.fn(() => (up ? Promise.resolve() : Promise.reject(new TypeError('down'))));
  const connection = new Connection(probe, 1000);
  const states: string[] = [];
  connection.onChange((state) => states.push(state));
  connection.failed(new TypeError('fetch failed'));
  connection.failed(new ConnectError('gone', Code.Unavailable));
  expect(states).toEqual(['lost']);
  await vi.advanceTimersByTimeAsync(3500);
  expect(probe.mock.calls.length).toBe(3);
  up = true;
  await vi.advanceTimersByTimeAsync(1000);
  expect(states).toEqual(['lost', 'connected']);
  await vi.advanceTimersByTimeAsync(5000);
  expect(probe.mock.calls.length).toBe(4);
});

test('a revoked token asks for a login', () => {
  const connection = new Connection(() => Promise.resolve());
  connection.failed(new ConnectError('revoked', Code.Unauthenticated));
  expect(connection.state).toBe('login');
});

test('what failed is tried again when the connection is restored', async () => {
  const probe = vi.fn(() => Promise.resolve());
  const connection = new Connection(probe, 1000);
  const closed = new AbortController();
  const lost = new ConnectError('gone', Code.Unavailable);
  const actions = { open: vi.fn(), closed: vi.fn(), other: vi.fn() };
  const open = new AbortController();
  connection.whenRestored(lost, open.signal, actions.open);
  connection.whenRestored(lost, closed.signal, actions.closed);
  connection.whenRestored(new ConnectError('no', Code.NotFound), open.signal, actions.other);
  closed.abort();
  expect(connection.state).toBe('lost');
  expect(actions.open).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(1000);
  connection.lose();
  await vi.advanceTimersByTimeAsync(1000);
  expect(connection.state).toBe('connected');
  expect(actions.open).toHaveBeenCalledTimes(1);
  expect(actions.closed).not.toHaveBeenCalled();
  expect(actions.other).not.toHaveBeenCalled();
});

test('an error of a call is not a lost connection', () => {
  const connection = new Connection(() => Promise.resolve());
  connection.failed(new ConnectError('no clip', Code.NotFound));
  expect(connection.state).toBe('connected');
});
