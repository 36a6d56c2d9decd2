import { Code } from '@connectrpc/connect';
import type { Api } from '../api/api';
import { hasCode, isConnectionLost } from '../api/errors';
import { OperationState, type Operation } from '../api/messages';
import { element } from '../dom/element';
import { percent } from '../dom/format';
import { Notice } from '../dom/notice';
import { pause, whileVisible } from '../watch/waiting';

const kWaitMilliseconds = 700;

export function isDone(operation: Operation): boolean {
  return (
    operation.state === OperationState.SUCCEEDED ||
    operation.state === OperationState.FAILED ||
    operation.state === OperationState.CANCELLED
  );
}

// The progress of an operation, such as the rebuild of a model, until it is done.
export class OperationProgress {
  readonly node: HTMLElement;
  private readonly bar = element('progress', { max: 1, value: 0, 'aria-label': 'Progress' });
  private readonly text = element('span', { class: 'hint', role: 'status' });
  private readonly notice = new Notice();
  private watched = '';
  private ended = '';

  constructor(
    private readonly api: Api,
    private readonly signal: AbortSignal,
    private readonly done: (operation: Operation) => void = () => undefined,
  ) {
    this.node = element(
      'div',
      { class: 'operation', hidden: true },
      element('div', { class: 'row' }, this.bar, this.text),
      this.notice.node,
    );
  }

  // Follows an operation instead of the one before.
  watch(operation: Operation): void {
    // It can be older than what is shown.
    if (operation.name === this.watched || operation.name === this.ended) return;
    this.notice.clear();
    this.draw(operation);
    this.watched = operation.name;
    void this.follow(operation.name);
  }

  private async follow(name: string): Promise<void> {
    while (!this.signal.aborted && this.watched === name) {
      try {
        const request = { name, timeout: { nanos: kWaitMilliseconds * 1_000_000 } };
        const { operation } = await whileVisible(this.signal, (signal) =>
          this.api.operations.waitOperation(request, { signal }),
        );
        if (!operation || this.watched !== name) return;
        this.draw(operation);
        if (!isDone(operation)) continue;
        this.watched = '';
        this.ended = name;
        this.done(operation);
        return;
      } catch (error) {
        // The store of the server can be away for a while.
        if (!isConnectionLost(error) && !hasCode(error, Code.Unavailable)) {
          this.watched = '';
          this.notice.error(error);
          return;
        }
        await pause(kWaitMilliseconds, this.signal);
      }
    }
  }

  private draw(operation: Operation): void {
    this.node.hidden = false;
    this.bar.value = operation.progress;
    this.bar.hidden = isDone(operation);
    if (operation.state === OperationState.SUCCEEDED)
      this.text.textContent = 'Model is up to date.';
    else if (operation.state === OperationState.CANCELLED)
      this.text.textContent = 'Update of the model cancelled.';
    else if (operation.result.case === 'error')
      this.text.textContent = `Update of the model failed: ${operation.result.value.message}`;
    else this.text.textContent = `Model: ${operation.stage}, ${percent(operation.progress)}`;
  }
}
