import { Code } from '@connectrpc/connect';
import type { Connection } from '../api/connection';
import { describeError, hasCode, isConnectionLost } from '../api/errors';
import { Notice } from '../dom/notice';
import type { WatchObserver } from './database_watch';

// Shows why the changes of other clients do not arrive, until they arrive again.
export class WatchNotice implements WatchObserver {
  private readonly notice = new Notice();
  private shown = '';

  constructor(private readonly connection: Connection) {}

  get node(): HTMLElement {
    return this.notice.node;
  }

  failed(error: unknown): void {
    this.connection.failed(error);
    // The shell shows these.
    if (isConnectionLost(error) || hasCode(error, Code.Unauthenticated)) {
      this.works();
      return;
    }
    const text = `Changes of others are not shown: ${describeError(error)?.message ?? ''}`;
    // Otherwise screen readers say it again at each attempt.
    if (text === this.shown) return;
    this.shown = text;
    this.notice.message(text);
  }

  works(): void {
    this.shown = '';
    this.notice.clear();
  }
}
