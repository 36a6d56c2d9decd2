import { Code } from '@connectrpc/connect';
import type { CallObserver } from './api';
import { describeError, hasCode, isConnectionLost } from './errors';

// If a connection is lost again within this time, the server answers probes but not calls.
const kSettleMilliseconds = 10_000;
const kMaxPauseMilliseconds = 30_000;

export type ConnectionState = 'connected' | 'lost' | 'login';

// The state of the connection, from the outcomes of calls. When it is lost, it asks `probe` until
// an answer arrives; `probe` rejects while no server answers. The pause before the first probe grows
// while calls fail again and again after answers, so that their repetition does not load the server.
export class Connection implements CallObserver {
  private current: ConnectionState = 'connected';
  private readonly listeners = new Set<
    (state: ConnectionState, previous: ConnectionState) => void
  >();
  private reason = '';
  private restoredTime = -Infinity;
  // How often in a row the connection was lost soon after it was restored.
  private relapses = 0;
  // Until the probe that it starts is answered.
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly probe: () => Promise<unknown>,
    private readonly retryMilliseconds = 1000,
  ) {}

  get state(): ConnectionState {
    return this.current;
  }

  // Why the state became `login`, for the user; empty if the browser has no token.
  get loginReason(): string {
    return this.reason;
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
    else if (hasCode(error, Code.Unauthenticated)) {
      const described = describeError(error);
      this.reason = described?.reason === 'TOKEN_MISSING' ? '' : (described?.message ?? '');
      this.change('login');
    }
  }

  // Reports a lost connection, for example of a stream.
  lose(): void {
    if (this.current === 'login') return;
    this.change('lost');
    const pause = this.retryMilliseconds * 2 ** Math.max(0, this.relapses - 1);
    this.retry(Math.min(pause, kMaxPauseMilliseconds));
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

  private retry(milliseconds: number): void {
    this.timer ??= setTimeout(() => void this.askAgain(), milliseconds);
  }

  private async askAgain(): Promise<void> {
    const isAnswered =
      this.current === 'lost' &&
      (await this.probe().then(
        () => true,
        () => false,
      ));
    this.timer = undefined;
    if (this.current !== 'lost') return;
    if (isAnswered) this.change('connected');
    else this.retry(this.retryMilliseconds);
  }

  private change(state: ConnectionState): void {
    if (state === this.current) return;
    const previous = this.current;
    this.current = state;
    if (previous === 'lost') this.restoredTime = performance.now();
    if (state === 'lost') {
      const isRelapse = performance.now() - this.restoredTime < kSettleMilliseconds;
      this.relapses = isRelapse ? this.relapses + 1 : 0;
    }
    for (const listener of [...this.listeners]) listener(state, previous);
  }
}

// A call that can be tried again, by the user or when the connection is restored. Each attempt aborts
// the one before, and what waits for a restored connection since then.
export class NewestCall {
  private attempt = new AbortController();

  // `signal` ends all attempts.
  constructor(private readonly signal: AbortSignal) {
    signal.addEventListener('abort', () => {
      this.attempt.abort();
    });
  }

  // Ends the attempt without a new one.
  stop(): void {
    this.attempt.abort();
  }

  // The signal of a new attempt.
  begin(): AbortSignal {
    this.stop();
    this.attempt = new AbortController();
    if (this.signal.aborted) this.attempt.abort();
    return this.attempt.signal;
  }
}
