import { create } from '@bufbuild/protobuf';
import { FieldMaskSchema } from '@bufbuild/protobuf/wkt';
import { Code } from '@connectrpc/connect';
import type { Api } from '../../api/api';
import { hasCode } from '../../api/errors';
import type { Clip, FieldValue } from '../../api/messages';
import { button, element, replaceChildren } from '../../dom/element';
import { seconds, time } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { ClipForm } from './clip_form';
import { changedPaths, clipOf, valuesOf } from './clip_values';

export interface ClipPropertiesOptions {
  api: Api;
  clip: Clip;
  editable: boolean;
  signal: AbortSignal;
  announce(text: string): void;
}

// The properties of a clip, and the form to change some. A change sends the etag of the clip, so
// that the change of another client in between is a conflict and not lost.
export class ClipProperties {
  readonly node = element('details', { class: 'panel stack' });
  private readonly list = element('div');
  private readonly editor = element('div', { class: 'stack' });
  private readonly notice = new Notice();
  private clip: Clip;
  private form: ClipForm | undefined;
  private saving = false;

  constructor(private readonly options: ClipPropertiesOptions) {
    this.clip = options.clip;
    const summary = element('summary', {}, 'Properties');
    this.node.append(summary, this.list, this.editor, this.notice.node);
    this.draw();
    this.closeForm();
  }

  // Shows a version of the clip that another client has stored. A form that is open stays; saving it
  // is then a conflict.
  follow(clip: Clip): void {
    if (clip.etag === this.clip.etag || this.form) return;
    this.clip = clip;
    this.draw();
  }

  private draw(): void {
    replaceChildren(this.list, clipDetails(this.clip));
  }

  private closeForm(): void {
    this.form = undefined;
    this.notice.clear();
    const edit = button('Edit', () => {
      this.openForm();
    });
    replaceChildren(this.editor, this.options.editable && edit);
  }

  private openForm(): void {
    const opened = valuesOf(this.clip);
    const form = new ClipForm(
      this.clip,
      () => {
        void this.save(form, changedPaths(opened, form.values));
      },
      () => {
        this.closeForm();
      },
    );
    this.form = form;
    replaceChildren(this.editor, form.node);
    form.focus();
  }

  private async save(form: ClipForm, paths: string[]): Promise<void> {
    // A second press would be a conflict with the change of the first.
    if (this.saving) return;
    if (paths.length === 0) {
      this.closeForm();
      return;
    }
    this.saving = true;
    this.notice.clear();
    try {
      const { name, etag } = this.clip;
      const { clip } = await this.options.api.clips.updateClip(
        {
          clip: { name, etag, ...clipOf(form.values) },
          updateMask: create(FieldMaskSchema, { paths }),
        },
        { signal: this.options.signal },
      );
      if (clip) this.clip = clip;
      this.draw();
      this.closeForm();
      this.options.announce('Properties saved');
    } catch (error) {
      if (hasCode(error, Code.Aborted)) await this.showConflict(paths);
      else this.notice.error(error);
    } finally {
      this.saving = false;
    }
  }

  // Shows the stored version above the form. Saving again replaces what the user has changed.
  private async showConflict(paths: readonly string[]): Promise<void> {
    try {
      const { clip } = await this.options.api.clips.getClip(
        { name: this.clip.name },
        { signal: this.options.signal },
      );
      if (!clip) return;
      this.clip = clip;
      this.draw();
      const conflict = new Error(
        'Nothing is saved: another client has changed the clip. Its stored properties are above. ' +
          `Save again to replace its ${paths.join(', ')} by yours.`,
      );
      const discard = button('Discard my changes', () => {
        this.closeForm();
      });
      this.notice.error(conflict, [discard]);
    } catch (error) {
      this.notice.error(error);
    }
  }
}

// The properties of a clip as a list; empty ones are left out.
function clipDetails(clip: Clip): HTMLElement {
  const entries: [string, string][] = [
    ['Label', clip.label],
    ['Subject', clip.subject],
    ['Title', clip.title],
    ['Description', clip.description],
    ['Tags', clip.tags.join(', ')],
    ['File', clip.fileName],
    ['Take', clip.take],
    ['Duration', `${seconds(clip.durationSeconds)}, ${clip.frameCount} frames`],
    ['Frame rate of the file', clip.sourceFrameRateHz > 0 ? `${clip.sourceFrameRateHz} Hz` : ''],
    ['Leg length', `${clip.legLengthM.toFixed(3)} m`],
    ['Stored', time(clip.createTime)],
    ['Edited', time(clip.updateTime)],
    ['Report', clip.sourceReport],
    ['Glitches', clip.glitches],
    ['Error of deriving again', clip.deriveError],
    ...Object.entries(clip.fields).map(([name, value]): [string, string] => [name, textOf(value)]),
  ];
  const list = element('dl', { class: 'details' });
  for (const [name, value] of entries) {
    if (value !== '') list.append(element('dt', {}, name), element('dd', {}, value));
  }
  return list;
}

function textOf(field: FieldValue): string {
  const { value } = field;
  switch (value.case) {
    case 'text':
      return value.value;
    case 'number':
    case 'flag':
      return String(value.value);
    case 'time':
      return time(value.value);
    default:
      return '';
  }
}
