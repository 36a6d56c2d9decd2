import { readDatabaseIds } from '../../api/lists';
import { databaseName } from '../../api/resource_names';
import type { Disposer } from '../../dom/disposer';
import { downloadBytes } from '../../dom/files';
import { button, element, labelled } from '../../dom/element';
import { bytes } from '../../dom/format';
import { Notice } from '../../dom/notice';
import type { ViewContext } from '../../shell/view';

const kCollectBytes = 8 * 1024 * 1024;

interface Block {
  totalBytes: bigint;
  block: Uint8Array;
}

// Downloads: a backup of the whole store (admin), or one database.
export class BackupPanel {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly listNotice = new Notice();
  private readonly bar = element('progress', {
    max: 1,
    value: 0,
    hidden: true,
    'aria-label': 'Download',
  });
  private readonly database = element('select');

  constructor(
    private readonly context: ViewContext,
    private readonly disposer: Disposer,
    admin: boolean,
  ) {
    const { api } = context;
    const { signal } = disposer;
    const backup = button('Download backup of the store', () => {
      void this.download('motiondb.backup', api.store.backupStore({}, { signal }));
    });
    const exported = button('Download database', () => {
      const id = this.database.value;
      void this.download(
        `${id}.motiondb`,
        api.store.exportDatabase({ name: databaseName(id) }, { signal }),
      );
    });
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Downloads' },
      element('h2', {}, 'Downloads'),
      element(
        'div',
        { class: 'row' },
        admin && backup,
        labelled('Database', this.database),
        exported,
        this.bar,
      ),
      this.listNotice.node,
      this.notice.node,
    );
    void this.listDatabases();
  }

  private async listDatabases(): Promise<void> {
    try {
      const { signal } = this.disposer;
      const ids = await readDatabaseIds(this.context.api, { signal });
      this.database.append(...ids.map((id) => element('option', { value: id }, id)));
      this.listNotice.clear();
    } catch (error) {
      this.listNotice.error(error);
      this.context.connection.whenRestored(
        error,
        this.disposer.signal,
        () => void this.listDatabases(),
      );
    }
  }

  // The browser gets the file when its last block is there, so that a broken stream leaves none.
  private async download(fileName: string, stream: AsyncIterable<Block>): Promise<void> {
    this.notice.clear();
    this.bar.hidden = false;
    this.bar.value = 0;
    try {
      // A Blob is outside the memory of the page; the browser keeps a large one on the disk.
      let file = new Blob();
      let parts: Uint8Array[] = [];
      let total = 0;
      let received = 0;
      let collected = 0;
      for await (const { totalBytes, block } of stream) {
        if (totalBytes > 0n) total = Number(totalBytes);
        parts.push(block);
        received += block.length;
        if (received - collected >= kCollectBytes) {
          file = new Blob([file, ...parts] as BlobPart[]);
          parts = [];
          collected = received;
        }
        if (total > 0) this.bar.value = received / total;
      }
      if (received < total) throw new Error(`Expected ${total} bytes, got ${received}.`);
      downloadBytes(fileName, [file, ...parts]);
      this.notice.message(`${fileName}: ${bytes(received)}`);
    } catch (error) {
      this.notice.error(error);
    } finally {
      this.bar.hidden = true;
    }
  }
}
