import { Code } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { OperationState, type Operation } from '../api/messages';
import { serverError } from '../api/test_server';
import { OperationProgress } from './operation_progress';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

test('a hidden page does not wait for an operation', async () => {
  const operation = {
    name: 'operations/1',
    state: OperationState.RUNNING,
    result: { case: undefined },
    progress: 0.5,
  };
  const waitOperation = vi.fn(async () => {
    await new Promise((resolve) => setTimeout(resolve, 700));
    return { operation };
  });
  const api = { operations: { waitOperation } } as unknown as Api;
  const closing = new AbortController();
  const done = vi.fn();
  const hidden = vi.spyOn(document, 'hidden', 'get').mockReturnValue(true);
  const progress = new OperationProgress(api, closing.signal, done);
  progress.watch(operation as unknown as Operation);
  await vi.advanceTimersByTimeAsync(5000);
  expect(waitOperation).not.toHaveBeenCalled();
  hidden.mockReturnValue(false);
  document.dispatchEvent(new Event('visibilitychange'));
  await vi.advanceTimersByTimeAsync(1000);
  expect(waitOperation).toHaveBeenCalledTimes(2);
  operation.state = OperationState.SUCCEEDED;
  await vi.advanceTimersByTimeAsync(1000);
  expect(done).toHaveBeenCalledTimes(1);
});

test('progress does not fall if an older state arrives', async () => {
  const operation = (progress: number, state = OperationState.RUNNING) =>
    ({ name: 'operations/1', state, result: { case: undefined }, progress }) as Operation;
  let newest = operation(0.5);
  const waitOperation = vi.fn(async () => {
    await new Promise((resolve) => setTimeout(resolve, 100));
    return { operation: newest };
  });
  const api = { operations: { waitOperation } } as unknown as Api;
  const done = vi.fn();
  const progress = new OperationProgress(api, new AbortController().signal, done);
  const bar = progress.node.querySelector('progress')!;
  progress.watch(operation(0.1));
  await vi.advanceTimersByTimeAsync(150);
  progress.watch(operation(0.2));
  expect(bar.value).toBe(0.5);
  newest = operation(1, OperationState.SUCCEEDED);
  await vi.advanceTimersByTimeAsync(300);
  progress.watch(operation(0.3));
  await vi.advanceTimersByTimeAsync(300);
  expect(bar.hidden).toBe(true);
  expect(progress.node.textContent).toBe('Model is up to date.');
  expect(done).toHaveBeenCalledTimes(1);
});

test('an operation is followed although the store of the server is away for a while', async () => {
  const ended = { name: 'operations/1', state: OperationState.SUCCEEDED, progress: 1 };
  const waitOperation = vi
    .fn(() => Promise.resolve({ operation: ended }))
    .mockRejectedValueOnce(serverError(Code.Unavailable, 'STORE_UNREACHABLE'));
  const api = { operations: { waitOperation } } as unknown as Api;
  const progress = new OperationProgress(api, new AbortController().signal);
  progress.watch({ ...ended, state: OperationState.RUNNING, result: {} } as Operation);
  await vi.advanceTimersByTimeAsync(1000);
  expect(waitOperation).toHaveBeenCalledTimes(2);
  expect(progress.node.textContent).toBe('Model is up to date.');
});
