import { Code } from '@connectrpc/connect';
import { describeError, hasCode } from '../../api/errors';
import type { Operation, UploadClipResponse } from '../../api/messages';
import { NewestCall } from '../../api/connection';
import { databaseName, lastPart } from '../../api/resource_names';
import { button, element, labelled } from '../../dom/element';
import { readFile } from '../../dom/files';
import { seconds } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { hrefOf } from '../../shell/place';
import type { ViewContext } from '../../shell/view';
import type { MappingEditor } from './mapping_editor';
import type { UploadJob } from './upload_files';

export type UploadState = 'new' | 'checking' | 'checked' | 'storing' | 'stored' | 'failed';

export interface UploadEvents {
  stored(operation: Operation | undefined): void;
  changed(): void;
  closed(): void;
}

// One file on its way into the database.
export class UploadItem {
  readonly node: HTMLElement;
  state: UploadState = 'new';
  private readonly status = element('span', { class: 'hint', role: 'status' }, 'waiting');
  private readonly notice = new Notice();
  private readonly label = element('input', { maxlength: 255, placeholder: 'unlabelled' });
  private readonly subject = element('input', { maxlength: 255 });
  private readonly take = element('input', { maxlength: 255 });
  private readonly takeField = labelled('Take', this.take, { class: 'field' });
  private readonly report = element('p', { class: 'hint' });
  private readonly editedHint = element(
    'p',
    { class: 'hint', role: 'status', hidden: true },
    'The edited rules of the mapping are not used yet. Use or reset them, then store.',
  );
  private readonly details = element('details', {}, element('summary', {}, 'Mapping'));
  private readonly storeButton: HTMLButtonElement;
  private readonly abort = new AbortController();
  private readonly checking = new NewestCall(this.abort.signal);
  private checked: UploadClipResponse | undefined;
  private editor: MappingEditor | undefined;

  constructor(
    private readonly context: ViewContext,
    private readonly database: string,
    private readonly job: UploadJob<File>,
    private readonly events: UploadEvents,
  ) {
    this.storeButton = button('Store', () => void this.store(), { class: 'primary' });
    this.storeButton.disabled = true;
    this.takeField.hidden = true;
    this.details.hidden = true;
    this.take.addEventListener('change', () => void this.check(true));
    this.details.addEventListener('toggle', () => void this.drawMapping());
    this.node = element(
      'article',
      { class: 'upload-item stack', 'aria-label': job.motion.name },
      element(
        'div',
        { class: 'row' },
        element('strong', {}, job.motion.name),
        job.skeleton && element('span', { class: 'hint' }, `with ${job.skeleton.name}`),
        this.status,
      ),
      element(
        'div',
        { class: 'row' },
        labelled('Label', this.label),
        labelled('Subject', this.subject),
        this.takeField,
        this.storeButton,
        button('Remove', () => {
          this.dispose();
          this.events.closed();
        }),
      ),
      this.report,
      this.editedHint,
      this.notice.node,
      this.details,
    );
  }

  // Checked, with the rules that the editor shows.
  get isReady(): boolean {
    return this.state === 'checked' && this.editor?.isEdited !== true;
  }

  // Checks the file on the server without storing it; shows the mapping if `open`. The answer of a
  // check before this one is dropped.
  async check(open: boolean): Promise<void> {
    if (this.state === 'storing' || this.state === 'stored') return;
    const signal = this.checking.begin();
    this.enter('checking', 'checking');
    this.notice.clear();
    try {
      const checked = await this.upload(true, signal);
      if (signal.aborted) return;
      this.show(checked, open);
      this.enter('checked', 'checked');
    } catch (error) {
      if (!signal.aborted) this.fail(error);
    }
  }

  async store(): Promise<void> {
    const { signal } = this.abort;
    this.enter('storing', 'storing');
    this.notice.clear();
    try {
      const { clip, operation } = await this.upload(false, signal);
      if (signal.aborted || !clip) return;
      const id = lastPart(clip.name);
      this.enter('stored', 'stored as ');
      this.status.append(
        element('a', { href: hrefOf({ view: 'clip', database: this.database, path: [id] }) }, id),
      );
      this.details.hidden = true;
      this.removeEditor();
      this.events.stored(operation);
    } catch (error) {
      if (!signal.aborted) this.fail(error);
    }
  }

  dispose(): void {
    this.abort.abort();
    this.removeEditor();
    this.node.remove();
  }

  private async upload(validateOnly: boolean, signal: AbortSignal): Promise<UploadClipResponse> {
    const { motion, skeleton } = this.job;
    signal.throwIfAborted(); // the item can be closed while it waits for those before
    return this.context.api.clips.uploadClip(
      {
        header: {
          parent: databaseName(this.database),
          fileName: motion.name,
          skeletonFileName: skeleton?.name ?? '',
          label: this.label.value.trim(),
          subject: this.subject.value.trim(),
          conventions: { take: this.take.value.trim() },
          validateOnly,
        },
        file: await readFile(motion),
        ...(skeleton ? { skeletonFile: await readFile(skeleton) } : {}),
      },
      { signal },
    );
  }

  private show(checked: UploadClipResponse, open: boolean): void {
    const { clip } = checked;
    if (clip) {
      const duration = seconds(clip.durationSeconds);
      this.report.textContent = `${duration}, ${clip.frameCount} frames. ${clip.sourceReport}`;
    }
    this.removeEditor();
    this.checked = checked;
    this.details.hidden = false;
    if (this.details.open) void this.drawMapping();
    else this.details.open = open;
  }

  // The mapping of an open item. A browser has few pictures in three dimensions at a time, and a
  // folder has many files: a closed item keeps only its rules.
  private async drawMapping(): Promise<void> {
    const { checked, details } = this;
    const isOpen = () => details.open;
    if (!isOpen()) this.editor?.hideFigure();
    if (!checked || !isOpen()) return;
    try {
      // Loaded here: the list of clips itself needs no graphics.
      const { MappingEditor: Editor } = await import('./mapping_editor');
      if (this.checked !== checked) return;
      if (!this.editor) {
        this.editor = new Editor(this.context, this.database, this.job.motion.name, checked, {
          edited: () => {
            this.update();
          },
          applied: () => void this.check(true),
        });
        details.append(this.editor.node);
      }
      if (isOpen()) this.editor.showFigure();
    } catch (error) {
      this.notice.error(error);
    }
  }

  private removeEditor(): void {
    this.checked = undefined;
    this.editor?.dispose();
    this.editor = undefined;
  }

  private fail(error: unknown): void {
    const described = describeError(error);
    this.takeField.hidden = described?.reason !== 'TAKE_REQUIRED' && this.take.value === '';
    const existing = described?.metadata['clip'];
    const link =
      hasCode(error, Code.AlreadyExists) && existing !== undefined
        ? [
            element(
              'a',
              {
                href: hrefOf({ view: 'clip', database: this.database, path: [lastPart(existing)] }),
              },
              'Open the stored clip',
            ),
          ]
        : [];
    this.notice.error(error, [...link, button('Check again', () => void this.check(true))]);
    this.enter('failed', 'failed');
  }

  private enter(state: UploadState, text: string): void {
    this.state = state;
    this.status.textContent = text;
    this.update();
  }

  private update(): void {
    const { state } = this;
    this.storeButton.disabled = !this.isReady;
    this.editedHint.hidden = state !== 'checked' || this.isReady;
    const isSent = state === 'storing' || state === 'stored';
    for (const input of [this.label, this.subject, this.take]) input.disabled = isSent;
    this.details.inert = state === 'checking' || state === 'storing';
    this.events.changed();
  }
}
