// Collects what a view has to undo when it closes.
export class Disposer {
  private readonly actions: (() => void)[] = [];
  private readonly controller = new AbortController();

  // Aborts when `dispose` runs: for calls and event listeners.
  get signal(): AbortSignal {
    return this.controller.signal;
  }

  get disposed(): boolean {
    return this.controller.signal.aborted;
  }

  // Runs an action on disposal, last added first; immediately if disposal is over.
  add(action: () => void): void {
    if (this.disposed) action();
    else this.actions.push(action);
  }

  // Adds an event listener that disposal removes.
  listen<Type extends keyof HTMLElementEventMap>(
    target: EventTarget,
    type: Type | string,
    listener: (event: HTMLElementEventMap[Type]) => void,
    options: AddEventListenerOptions = {},
  ): void {
    target.addEventListener(type, listener as EventListener, { ...options, signal: this.signal });
  }

  dispose(): void {
    if (this.disposed) return;
    this.controller.abort();
    for (const action of this.actions.reverse()) action();
    this.actions.length = 0;
  }
}
