import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { OperationState, type Operation } from '../api/messages';
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
