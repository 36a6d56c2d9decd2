import { button, element, labelled, offerNames } from '../../dom/element';
import type { QuerySettings } from './query_settings';

// What the user wants to ask about.
export interface QuerySource {
  settings: Partial<QuerySettings>;
  // Dropped or chosen files; empty: the clip of the settings.
  files: readonly File[];
}

// The motion, filter, track and window of a query. A file can also be dropped on the form.
export class SourceForm {
  readonly node: HTMLFormElement;
  private readonly clip: HTMLInputElement;
  private readonly from: HTMLInputElement;
  private readonly to: HTMLInputElement;
  private readonly without: HTMLInputElement;
  private readonly filter: HTMLInputElement;
  private readonly track: HTMLInputElement;
  private readonly window: HTMLInputElement;
  private readonly file = element('input', { type: 'file', multiple: true });
  private readonly clips = element('datalist', { id: 'query-clips' });
  private readonly tracks = element('datalist', { id: 'query-tracks' });

  constructor(settings: QuerySettings, ask: (source: QuerySource) => void) {
    const seconds = { type: 'number', min: 0, step: 'any', class: 'short' };
    this.clip = element('input', { list: 'query-clips', value: settings.clip });
    this.from = element('input', { ...seconds, value: settings.from, placeholder: 'start' });
    this.to = element('input', { ...seconds, value: settings.to, placeholder: 'end' });
    this.without = element('input', { type: 'checkbox', checked: settings.without });
    this.filter = element('input', { value: settings.filter, placeholder: 'label = walk' });
    this.track = element('input', {
      list: 'query-tracks',
      value: settings.track,
      placeholder: 'action',
    });
    this.window = element('input', { ...seconds, value: settings.window });
    this.node = element(
      'form',
      { class: 'panel row drop-zone', 'aria-label': 'Query' },
      labelled('Clip', this.clip),
      labelled('From, s', this.from),
      labelled('To, s', this.to),
      labelled('Leave the clip out of the answer', this.without, { class: 'field inline' }),
      labelled('or motion file (drop it here), with its ASF or URDF', this.file),
      labelled('Filter', this.filter, { class: 'field grow' }),
      labelled('Track', this.track),
      labelled('Window, s', this.window),
      element('button', { type: 'submit', class: 'primary' }, 'Ask'),
      button('Clear file', () => {
        this.file.value = '';
      }),
      this.clips,
      this.tracks,
    );
    this.node.addEventListener('submit', (event) => {
      event.preventDefault();
      ask({ settings: this.values(), files: [...(this.file.files ?? [])] });
    });
    this.acceptDrops(ask);
  }

  // Names to choose from.
  offer(clips: readonly string[], tracks: readonly string[]): void {
    offerNames(this.clips, clips);
    offerNames(this.tracks, tracks);
  }

  private values(): Partial<QuerySettings> {
    const numberOf = (input: HTMLInputElement) =>
      input.value === '' || !(input.valueAsNumber >= 0) ? undefined : input.valueAsNumber;
    return {
      clip: this.file.files?.length ? '' : this.clip.value.trim(),
      from: numberOf(this.from),
      to: numberOf(this.to),
      without: this.without.checked,
      filter: this.filter.value.trim(),
      track: this.track.value.trim(),
      window: numberOf(this.window) ?? 0.4,
    };
  }

  private acceptDrops(ask: (source: QuerySource) => void): void {
    this.node.addEventListener('dragover', (event) => {
      event.preventDefault();
      this.node.classList.add('over');
    });
    this.node.addEventListener('dragleave', () => {
      this.node.classList.remove('over');
    });
    this.node.addEventListener('drop', (event) => {
      event.preventDefault();
      this.node.classList.remove('over');
      const files = event.dataTransfer?.files;
      if (!files || files.length === 0) return;
      // The form shows what is asked about, and asks about it again.
      this.file.files = files;
      ask({ settings: this.values(), files: [...files] });
    });
  }
}
