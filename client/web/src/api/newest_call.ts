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
