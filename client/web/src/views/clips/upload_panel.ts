import type { Operation } from '../../api/messages';
import type { Disposer } from '../../dom/disposer';
import { button, element, labelled } from '../../dom/element';
import type { ViewContext } from '../../shell/view';
import { UploadItem } from './upload_item';
import { uploadJobs } from './upload_files';

const kOpenDetails = 1;

// Takes files by drag and drop or from a dialog. Each is checked first; the user then looks at the
// detected mapping, can change it, and stores the clip.
export class UploadPanel {
  readonly node: HTMLElement;
  private readonly items: UploadItem[] = [];
  private readonly list = element('div', { class: 'stack' });
  private readonly hint = element(
    'p',
    { role: 'status', hidden: true },
    'A skeleton file needs its motion: drop or choose both together.',
  );
  private readonly storeAll: HTMLButtonElement;

  constructor(
    private readonly context: ViewContext,
    private readonly database: string,
    private readonly disposer: Disposer,
    private readonly stored: (operation: Operation | undefined) => void,
  ) {
    const input = element('input', { type: 'file', multiple: true });
    input.addEventListener('change', () => {
      this.add([...(input.files ?? [])]);
      input.value = '';
    });
    this.storeAll = button('Store all checked clips', () => void this.storeChecked(), {
      class: 'primary',
      hidden: true,
    });
    this.node = element(
      'section',
      { class: 'panel upload', 'aria-label': 'Upload' },
      element(
        'div',
        { class: 'row' },
        labelled('Upload motion files: drop them here, or choose', input),
        this.storeAll,
      ),
      this.hint,
      this.list,
    );
    this.listenToDrops();
    disposer.add(() => {
      for (const item of this.items) item.dispose();
    });
  }

  private listenToDrops(): void {
    this.disposer.listen(document, 'dragover', (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      this.node.classList.add('drop');
    });
    this.disposer.listen(document, 'dragleave', (event) => {
      if (event.relatedTarget === null) this.node.classList.remove('drop');
    });
    this.disposer.listen(document, 'drop', (event) => {
      if (!hasFiles(event)) return;
      event.preventDefault();
      this.node.classList.remove('drop');
      this.add([...(event.dataTransfer?.files ?? [])]);
    });
  }

  private add(files: File[]): void {
    const jobs = uploadJobs(files);
    this.hint.hidden = files.length === 0 || jobs.length > 0;
    for (const job of jobs) {
      const item = new UploadItem(this.context, this.database, job, {
        stored: (operation) => {
          this.stored(operation);
          this.update();
        },
        changed: () => {
          this.update();
        },
        closed: () => {
          this.items.splice(this.items.indexOf(item), 1);
          this.update();
        },
      });
      this.items.push(item);
      this.list.append(item.node);
    }
    void this.checkAll();
  }

  // Checks one file after the other, so that a burst does not fill the server.
  private async checkAll(): Promise<void> {
    for (const item of [...this.items]) {
      if (item.state === 'new') await item.check(this.items.length <= kOpenDetails);
    }
  }

  private async storeChecked(): Promise<void> {
    for (const item of [...this.items]) {
      if (item.isReady) await item.store();
    }
  }

  private update(): void {
    this.storeAll.hidden = this.items.filter((item) => item.isReady).length < 2;
  }
}

// False for text, which the user can drag into an input.
function hasFiles({ dataTransfer }: DragEvent): boolean {
  return dataTransfer?.types.includes('Files') === true;
}
