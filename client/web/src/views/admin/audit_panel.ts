import { Code } from '@connectrpc/connect';
import type { AuditEntry } from '../../api/messages';
import { NewestCall } from '../../api/connection';
import type { Disposer } from '../../dom/disposer';
import { button, element, replaceChildren } from '../../dom/element';
import { count, time } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { tableOf } from '../../dom/table';
import type { ViewContext } from '../../shell/view';

const kPageSize = 50;

// The audit log, newest first.
export class AuditPanel {
  readonly node: HTMLElement;
  private readonly reading: NewestCall;
  private readonly notice = new Notice();
  private readonly list = element('div');
  private readonly older: HTMLButtonElement;
  private entries: AuditEntry[] = [];
  private next = '';

  constructor(
    private readonly context: ViewContext,
    disposer: Disposer,
  ) {
    this.reading = new NewestCall(disposer.signal);
    this.older = button('Older entries', () => void this.read());
    const refresh = button('Refresh', () => {
      this.entries = [];
      this.next = '';
      void this.read();
    });
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Audit log' },
      element('div', { class: 'row' }, element('h2', {}, 'Audit log'), refresh),
      this.notice.node,
      this.list,
      this.older,
    );
    void this.read();
  }

  private async read(): Promise<void> {
    const signal = this.reading.begin();
    try {
      const page = await this.context.api.access.listAuditEntries(
        { pageSize: kPageSize, pageToken: this.next },
        { signal },
      );
      if (signal.aborted) return;
      this.notice.clear();
      this.entries.push(...page.entries);
      this.next = page.nextPageToken;
      this.draw();
    } catch (error) {
      if (!signal.aborted) this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => void this.read());
    }
  }

  private draw(): void {
    this.older.hidden = this.next === '';
    replaceChildren(
      this.list,
      tableOf(
        'Audit log',
        [
          { title: 'Entry', number: true },
          { title: 'Time' },
          { title: 'Caller' },
          { title: 'Address' },
          { title: 'Call' },
          { title: 'Resource' },
          { title: 'Result' },
          { title: 'Request' },
        ],
        this.entries.map((entry) => [
          count(entry.sequence),
          time(entry.time),
          entry.principal,
          entry.peer,
          entry.method,
          entry.resource,
          entry.code === 0 ? 'ok' : (Code[entry.code] ?? String(entry.code)),
          entry.requestId,
        ]),
      ),
    );
  }
}
