import { Code } from '@connectrpc/connect';
import type { CallObserver } from './api';
import { hasCode, isConnectionLost } from './errors';

export type ConnectionState = 'connected' | 'lost' | 'login';

// The state of the connection, from the outcomes of calls. When it is lost, it asks `probe` until
// an answer arrives; `probe` rejects while no server answers.
export class Connection implements CallObserver {
  private current: ConnectionState = 'connected';
  private readonly listeners = new Set<
    (state: ConnectionState, previous: ConnectionState) => void
  >();
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly probe: () => Promise<unknown>,
    private readonly retryMilliseconds = 1000,
  ) {}

  get state(): ConnectionState {
    return this.current;
  }

  // Calls the listener at each change. Returns the function that removes it.
  onChange(listener: (state: ConnectionState, previous: ConnectionState) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  succeeded(): void {
    this.change('connected');
  }

  failed(error: unknown): void {
    if (isConnectionLost(error)) this.lose();
    else if (hasCode(error, Code.Unauthenticated)) this.change('login');
  }

  // Reports a lost connection, for example of a stream.
  lose(): void {
    if (this.current === 'login') return;
    this.change('lost');
    this.retry();
  }

  // After an error of a lost connection: runs the action once when the connection is restored, unless
  // the signal aborts first. Does nothing after other errors.
  whenRestored(error: unknown, signal: AbortSignal, action: () => void): void {
    if (!isConnectionLost(error) || signal.aborted) return;
    this.failed(error);
    const remove = this.onChange((state) => {
      if (state !== 'connected') return;
      remove();
      if (!signal.aborted) action();
    });
    signal.addEventListener('abort', remove, { once: true });
  }

  close(): void {
    clearTimeout(this.timer);
    this.listeners.clear();
  }

  private retry(): void {
    if (this.timer !== undefined) return;
    this.timer = setTimeout(() => {
      this.timer = undefined;
      if (this.current !== 'lost') return;
      this.probe().then(
        () => {
          this.change('connected');
        },
        () => {
          this.retry();
        },
      );
    }, this.retryMilliseconds);
  }

  private change(state: ConnectionState): void {
    if (state === this.current) return;
    const previous = this.current;
    this.current = state;
    for (const listener of [...this.listeners]) listener(state, previous);
  }
}
