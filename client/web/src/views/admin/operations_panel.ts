import { OperationKind, OperationState, type Operation } from '../../api/messages';
import { lastPart } from '../../api/resource_names';
import { mayActAs } from '../../api/session';
import type { Disposer } from '../../dom/disposer';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { time } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { poll } from '../../watch/waiting';
import { tableOf } from '../../dom/table';
import type { ViewContext } from '../../shell/view';
import { isDone } from '../operation_progress';

const kPollMilliseconds = 1500;
const kShown = 20;

// The newest operations with their progress; running ones can be cancelled.
export class OperationsPanel {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly cancelNotice = new Notice();
  private readonly list = element('div');

  constructor(
    private readonly context: ViewContext,
    private readonly disposer: Disposer,
  ) {
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Operations' },
      element('h2', {}, 'Operations'),
      this.notice.node,
      this.cancelNotice.node,
      this.list,
    );
    poll(disposer, kPollMilliseconds, () => this.read());
  }

  private async read(): Promise<void> {
    try {
      const { operations } = await this.context.api.operations.listOperations(
        { pageSize: kShown },
        { signal: this.disposer.signal },
      );
      this.notice.clear();
      // A click needs the same button when the pointer is released.
      if (this.list.matches(':active')) return;
      keepFocus(this.list, () => {
        this.draw(operations);
      });
    } catch (error) {
      this.notice.error(error);
    }
  }

  private draw(operations: readonly Operation[]): void {
    replaceChildren(
      this.list,
      operations.length === 0
        ? element('p', { class: 'hint' }, 'No operations.')
        : tableOf(
            'Operations',
            [
              { title: 'Database' },
              { title: 'Kind' },
              { title: 'State' },
              { title: 'Progress' },
              { title: 'Changed' },
              { title: 'Action' },
            ],
            operations.map((operation) => [
              lastPart(operation.database),
              operation.kind === OperationKind.REPROCESS ? 'derive clips again' : 'update model',
              stateText(operation),
              isDone(operation)
                ? ''
                : element('progress', {
                    max: 1,
                    value: operation.progress,
                    'aria-label': operation.stage,
                  }),
              time(operation.updateTime),
              !isDone(operation) &&
                mayActAs(this.context.session, 'ingester') &&
                this.cancelButton(operation),
            ]),
          ),
    );
  }

  private cancelButton(operation: Operation): HTMLElement {
    const cancel = () => {
      node.disabled = true;
      this.cancelNotice.clear();
      this.context.api.operations
        .cancelOperation({ name: operation.name }, { signal: this.disposer.signal })
        .then(() => this.read())
        .catch((error: unknown) => {
          node.disabled = false;
          this.cancelNotice.error(error);
        });
    };
    const node = button('Cancel', cancel, { 'data-key': operation.name });
    return node;
  }
}

function stateText(operation: Operation): string {
  switch (operation.state) {
    case OperationState.PENDING:
      return 'pending';
    case OperationState.RUNNING:
      return operation.stage;
    case OperationState.SUCCEEDED:
      return 'succeeded';
    case OperationState.FAILED:
      return operation.result.case === 'error'
        ? `failed: ${operation.result.value.message}`
        : 'failed';
    case OperationState.CANCELLED:
      return 'cancelled';
    default:
      return '';
  }
}
