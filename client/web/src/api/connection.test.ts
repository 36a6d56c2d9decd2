import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from './connection';
import { NoAnswerError } from './server_fetch';
import { serverError } from './test_server';

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
  connection.failed(new NoAnswerError(new TypeError('fetch failed')));
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
  expect(connection.loginReason).toBe('revoked');
});

test('a browser without a token gets no advice for other programs', () => {
  const connection = new Connection(() => Promise.resolve());
  connection.failed(serverError(Code.Unauthenticated, 'TOKEN_MISSING'));
  expect([connection.state, connection.loginReason]).toEqual(['login', '']);
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

test('an error of a call, or of the page itself, is not a lost connection', async () => {
  const connection = new Connection(() => Promise.resolve(), 1000);
  const action = vi.fn();
  for (const error of [new ConnectError('no clip', Code.NotFound), new TypeError('no property')]) {
    connection.failed(error);
    connection.whenRestored(error, new AbortController().signal, action);
    expect(connection.state).toBe('connected');
  }
  connection.lose();
  await vi.advanceTimersByTimeAsync(2000);
  expect(connection.state).toBe('connected');
  expect(action).not.toHaveBeenCalled();
});

test('one probe runs at a time, and its late answer does not end the login', async () => {
  const answers: (() => void)[] = [];
  const probe = vi.fn(() => new Promise<void>((resolve) => answers.push(resolve)));
  const connection = new Connection(probe, 1000);
  connection.lose();
  await vi.advanceTimersByTimeAsync(1000);
  connection.succeeded();
  connection.lose();
  await vi.advanceTimersByTimeAsync(5000);
  expect(probe).toHaveBeenCalledTimes(1);
  connection.failed(new ConnectError('revoked', Code.Unauthenticated));
  answers[0]?.();
  await vi.advanceTimersByTimeAsync(5000);
  expect(connection.state).toBe('login');
  expect(probe).toHaveBeenCalledTimes(1);
});

test('a call that fails again after each restored connection is repeated less and less', async () => {
  const probe = vi.fn(() => Promise.resolve());
  const connection = new Connection(probe, 1000);
  const gone = new ConnectError('gone', Code.Unavailable);
  const closing = new AbortController();
  const times: number[] = [];
  const began = performance.now();
  const call = () => {
    times.push((performance.now() - began) / 1000);
    connection.whenRestored(gone, closing.signal, call);
  };
  call();
  await vi.advanceTimersByTimeAsync(100_000);
  expect(times).toEqual([0, 1, 2, 4, 8, 16, 32, 62, 92]);
  // A connection that is lost later is probed after a second again.
  closing.abort();
  await vi.advanceTimersByTimeAsync(60_000);
  connection.lose();
  await vi.advanceTimersByTimeAsync(1000);
  expect(connection.state).toBe('connected');
});
