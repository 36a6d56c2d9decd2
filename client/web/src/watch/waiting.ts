import type { Disposer } from '../dom/disposer';

// Waits of loops that ask the server again and again.

// Resolves after a time, or as soon as the signal aborts: a loop that tries again would otherwise
// keep the closed view that it belongs to in memory.
export function pause(milliseconds: number, signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const end = () => {
      clearTimeout(timer);
      signal.removeEventListener('abort', end);
      resolve();
    };
    const timer = setTimeout(end, milliseconds);
    if (signal.aborted) end();
    else signal.addEventListener('abort', end);
  });
}

// Resolves when the page is visible, or when the signal aborts.
export function whenVisible(signal: AbortSignal): Promise<void> {
  return new Promise((resolve) => {
    const check = () => {
      if (document.hidden && !signal.aborted) return;
      document.removeEventListener('visibilitychange', check);
      signal.removeEventListener('abort', check);
      resolve();
    };
    document.addEventListener('visibilitychange', check);
    signal.addEventListener('abort', check);
    check();
  });
}

// Runs a call that keeps a connection open, only while the page is visible: the tabs of a browser
// share few connections to a server. Aborts the call when the page is hidden, and starts it again
// when the page is visible. Ends as the call does; after an abort of `signal` with its error.
export async function whileVisible<Result>(
  signal: AbortSignal,
  call: (signal: AbortSignal) => Promise<Result>,
): Promise<Result> {
  for (;;) {
    await whenVisible(signal);
    const ending = new AbortController();
    const check = () => {
      if (document.hidden || signal.aborted) ending.abort();
    };
    document.addEventListener('visibilitychange', check);
    signal.addEventListener('abort', check);
    check();
    try {
      return await call(ending.signal);
    } catch (error) {
      if (signal.aborted || !ending.signal.aborted) throw error;
    } finally {
      document.removeEventListener('visibilitychange', check);
      signal.removeEventListener('abort', check);
    }
  }
}

// Runs an action now and again a while after each end, until disposal. Pauses while the page is
// hidden.
export function poll(disposer: Disposer, milliseconds: number, action: () => Promise<void>): void {
  let timer: ReturnType<typeof setTimeout> | undefined;
  const run = async (): Promise<void> => {
    if (!document.hidden) await action();
    if (!disposer.disposed) timer = setTimeout(() => void run(), milliseconds);
  };
  disposer.add(() => {
    clearTimeout(timer);
  });
  void run();
}
