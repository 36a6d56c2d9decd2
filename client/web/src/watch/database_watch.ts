import { Code } from '@connectrpc/connect';
import type { Api } from '../api/api';
import type { Connection } from '../api/connection';
import { hasCode, describeError, isConnectionLost } from '../api/errors';
import type { WatchDatabaseResponse } from '../api/messages';
import { databaseName } from '../api/resource_names';
import { Notice } from '../dom/notice';
import { pause, whileVisible } from './waiting';

const kRetryMilliseconds = 2000;

// Whether changes arrive.
export interface WatchObserver {
  // The stream has sent a message.
  works(): void;
  // The stream has ended with an error, for example because the token was revoked.
  failed(error: unknown): void;
}

export interface WatchOptions {
  database: string;
  signal: AbortSignal;
  readonly observer: WatchObserver;
  // A stored transaction: its changes in order. Also called with no changes when it begins,
  // and if changes can have been missed: then the caller reads everything again.
  readonly changed: (changes: readonly WatchDatabaseResponse[]) => void;
}

// Follows the changes of a database, also those of other clients, until the signal aborts. After a
// lost connection, and after the page was hidden, it continues where it was. It ends if the
// database is deleted, or if the server has no such call; then the view shows changes when it is
// opened again.
export async function watchDatabase(
  api: Api,
  { database, signal, changed, observer }: WatchOptions,
): Promise<void> {
  const name = databaseName(database);
  let revision: bigint | undefined;
  while (!signal.aborted) {
    try {
      if (revision === undefined) {
        const stored = await api.databases.getDatabase({ name }, { signal });
        revision = stored.database?.revision ?? 0n;
        // The caller may have read before the changes up to it, or long ago.
        changed([]);
      }
      await whileVisible(signal, async (visible) => {
        const request = { name, afterRevision: revision ?? 0n };
        const stream = api.databases.watchDatabase(request, { signal: visible });
        let changes: WatchDatabaseResponse[] = [];
        for await (const response of stream) {
          observer.works();
          if (response.change.case !== undefined) changes.push(response);
          if (!response.upToDate) continue;
          revision = response.revision;
          if (changes.length > 0) changed(changes);
          changes = [];
        }
      });
    } catch (error) {
      // A cancelled call is that of a closed view.
      if (!hasCode(error, Code.Canceled)) observer.failed(error);
      if (isFinal(error)) return;
      if (hasCode(error, Code.OutOfRange, Code.FailedPrecondition, Code.InvalidArgument)) {
        revision = undefined;
      }
    }
    await pause(kRetryMilliseconds, signal);
  }
}

function isFinal(error: unknown): boolean {
  return hasCode(
    error,
    Code.NotFound,
    Code.Unimplemented,
    Code.PermissionDenied,
    Code.Unauthenticated,
  );
}

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
