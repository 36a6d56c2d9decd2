import type { Disposer } from './disposer';

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
