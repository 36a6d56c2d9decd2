import { Code } from '@connectrpc/connect';
import type { Connection } from '../api/connection';
import { hasCode } from '../api/errors';
import { lastPart } from '../api/resource_names';
import { SegmentSource, type Operation, type WatchDatabaseResponse } from '../api/messages';
import { button, element, labelled, replaceChildren } from '../dom/element';
import { keepFocus } from '../dom/focus';
import { Notice } from '../dom/notice';
import { snapToFrame } from '../motion/motion';
import type { PlaybackClock } from '../player/playback_clock';
import { freeRange, type TimeRange } from './segment_edit';
import { SegmentStore, type StoredSegment } from './segment_store';
import { Timeline } from './timeline';
import type { Api } from '../api/api';

export interface TimelineView {
  zoom: number; // 1: the whole clip
  segment: string; // id of the selected one; empty: none
}

export interface SegmentPanelOptions {
  api: Api;
  connection: Connection;
  clip: string;
  clock: PlaybackClock;
  editable: boolean;
  // Shown at first.
  view: TimelineView;
  signal: AbortSignal;
  // The user has changed the view.
  viewed(view: Partial<TimelineView>): void;
  // A change has started this operation of the model.
  operation(operation: Operation): void;
}

// The timeline of a clip and the form of the selected segment.
export class SegmentPanel {
  readonly node: HTMLElement;
  readonly timeline: Timeline;
  private readonly store: SegmentStore;
  private readonly form = element('div', { class: 'segment-form row' });
  private readonly notice = new Notice();
  private selected = '';
  // Name of the segment of the form, and the texts of its inputs when they were saved last.
  private formOf = '';
  private saved: readonly string[] = [];
  private running = 0;
  private lastChange: Promise<unknown> = Promise.resolve();
  private waiting: (readonly WatchDatabaseResponse[])[] = [];

  constructor(private readonly options: SegmentPanelOptions) {
    const { clock, view } = options;
    this.selected = view.segment === '' ? '' : `${options.clip}/segments/${view.segment}`;
    this.timeline = new Timeline(clock.duration, clock.frameRate, options.editable, {
      seek: (seconds) => {
        clock.seek(seconds);
      },
      select: (segment) => {
        this.select(segment?.name ?? '');
      },
      move: (segment, change) => {
        this.run(() => this.store.update(segment, change));
      },
    });
    this.store = new SegmentStore(
      options.api,
      options.clip,
      clock.duration,
      options.signal,
      (operation) => {
        this.timeline.setSegments(this.store.all);
        if (operation) options.operation(operation);
        this.showRange();
        this.drawForm();
      },
    );
    const zoom = element('input', { type: 'range', min: 1, max: 20, step: 0.5, value: view.zoom });
    zoom.addEventListener('input', () => {
      this.timeline.setZoom(Number(zoom.value));
    });
    zoom.addEventListener('change', () => {
      options.viewed({ zoom: Number(zoom.value) });
    });
    this.timeline.select(this.selected);
    this.timeline.setZoom(Number(zoom.value));
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Segments' },
      element(
        'div',
        { class: 'row' },
        element('h2', {}, 'Segments'),
        labelled('Zoom', zoom, { class: 'field inline' }),
        options.editable &&
          button('Undo last edit', () => {
            this.run(async () => {
              if (!(await this.store.undo())) this.notice.message('The clip has no edits.');
            });
          }),
      ),
      this.timeline.node,
      this.form,
      this.notice.node,
    );
    this.reload();
  }

  // Shows changes of the database by other clients. A form with input that is not saved stays, with
  // a notice; saving it is then a conflict. No changes: some can have been missed.
  follow(changes: readonly WatchDatabaseResponse[]): void {
    if (this.running > 0) {
      // Can be the echo of the change that runs.
      this.waiting.push(changes);
      return;
    }
    if (changes.length > 0 && !changes.some((change) => this.store.isNew(change))) return;
    if (this.isEdited()) {
      this.notice.message('Another client has changed the segments of this clip.', [
        this.reloadButton(),
      ]);
    } else {
      this.reload();
    }
  }

  private isEdited(): boolean {
    const inputs = [...this.form.querySelectorAll('input')];
    return inputs.some((input) => input.value !== input.defaultValue);
  }

  private select(name: string): void {
    this.selected = name;
    this.options.viewed({ segment: lastPart(name) });
    this.timeline.select(name);
    this.showRange();
    this.drawForm();
  }

  // The player repeats the selected segment.
  private showRange(): void {
    const segment = this.store.find(this.selected);
    this.options.clock.range = segment ? { begin: segment.start, end: segment.end } : null;
  }

  // Text that is typed but not saved stays in the form of the same segment.
  private drawForm(): void {
    const inputs = () => [...this.form.querySelectorAll('input')];
    const typed = inputs().map((input, i) =>
      input.value === input.defaultValue || input.value === this.saved[i] ? null : input.value,
    );
    const same = this.formOf === this.selected;
    this.formOf = this.selected;
    this.saved = [];
    keepFocus(this.form, () => {
      this.fillForm();
    });
    if (!same) return;
    inputs().forEach((input, i) => {
      input.value = typed[i] ?? input.value;
    });
  }

  private fillForm(): void {
    const segment = this.store.find(this.selected);
    if (!this.options.editable) {
      replaceChildren(
        this.form,
        segment && element('p', { class: 'hint' }, this.describe(segment)),
      );
      return;
    }
    replaceChildren(this.form, ...(segment ? this.editFields(segment) : this.createFields()));
  }

  private describe(segment: StoredSegment): string {
    const confidence =
      segment.confidence < 1 ? `, confidence ${segment.confidence.toFixed(2)}` : '';
    const author = segment.author === '' ? '' : `, changed by ${segment.author}`;
    return `${segment.track}: ${segment.label}${confidence}${author}`;
  }

  private editFields(segment: StoredSegment): HTMLElement[] {
    const label = element('input', {
      value: segment.label,
      maxlength: 255,
      required: true,
      'data-key': 'label',
    });
    const start = timeInput(segment.start, 'start');
    const end = timeInput(segment.end, 'end');
    const save = () => {
      const range = this.rangeOf(start, end);
      const change: Partial<TimeRange> & { label?: string } = {};
      if (label.value !== segment.label) change.label = label.value;
      if (Math.abs(range.start - segment.start) > 5e-4) change.start = range.start;
      if (Math.abs(range.end - segment.end) > 5e-4) change.end = range.end;
      if (Object.keys(change).length === 0) return;
      this.saved = [label.value, start.value, end.value];
      this.run(() => this.store.update(segment, change));
    };
    for (const input of [label, start, end]) {
      input.addEventListener('keydown', (event) => {
        if (event.key === 'Enter') save();
      });
    }
    return [
      labelled('Label', label),
      labelled('Start, s', start),
      labelled('End, s', end),
      button('Save', save, { class: 'primary', 'data-key': 'save' }),
      button('Delete', () => {
        this.run(() => this.store.remove(segment));
      }),
      button('New segment', () => {
        this.select('');
      }),
      element('p', { class: 'hint' }, this.describe(segment)),
    ];
  }

  private createFields(): HTMLElement[] {
    const track = element('input', {
      value: 'action',
      maxlength: 63,
      pattern: '[a-z0-9_\\-]+',
      'data-key': 'track',
    });
    const label = element('input', { maxlength: 255, 'data-key': 'label' });
    const create = () => {
      const { clock } = this.options;
      const name = track.value.trim() === '' ? 'action' : track.value.trim();
      const at = snapToFrame(clock.time, clock.frameRate);
      const text = label.value;
      this.run(async () => {
        const range = freeRange(name, at, this.coveringLeft(name), clock.duration);
        if (!range)
          throw new Error(`Track ${name} has a segment here. Move to a free time, or shorten it.`);
        const segment = await this.store.add(name, text, { start: at, end: range.end });
        this.select(segment.name);
      });
    };
    label.addEventListener('keydown', (event) => {
      if (event.key === 'Enter') create();
    });
    return [
      labelled('Track', track),
      labelled('Label', label),
      button('Add segment from here', create, { 'data-key': 'save' }),
    ];
  }

  // The segments, without one that an import made for the whole clip: the server replaces it.
  private coveringLeft(track: string): StoredSegment[] {
    const { duration } = this.options.clock;
    return this.store.all.filter(
      (segment) =>
        !(
          track === 'action' &&
          segment.source === SegmentSource.IMPORT &&
          segment.start === 0 &&
          segment.end >= duration - 0.02
        ),
    );
  }

  private rangeOf(start: HTMLInputElement, end: HTMLInputElement): TimeRange {
    const { frameRate } = this.options.clock;
    return {
      start: snapToFrame(Number(start.value), frameRate),
      end: snapToFrame(Number(end.value), frameRate),
    };
  }

  // Runs a change after those before; an error appears here. After a conflict the user can load the
  // stored version.
  private run(change: () => Promise<unknown>): void {
    this.notice.clear();
    ++this.running;
    this.lastChange = this.lastChange
      .then(change)
      .catch((error: unknown) => {
        this.timeline.setSegments(this.store.all);
        const conflict = hasCode(error, Code.Aborted, Code.NotFound);
        this.notice.error(error, conflict ? [this.reloadButton()] : []);
      })
      .finally(() => {
        --this.running;
        if (this.running > 0 || this.waiting.length === 0) return;
        const waiting = this.waiting.splice(0);
        const missed = waiting.some((changes) => changes.length === 0);
        this.follow(missed ? [] : waiting.flat());
      });
  }

  private reloadButton(): HTMLElement {
    return button('Load the stored segments', () => {
      this.reload();
    });
  }

  private reload(): void {
    const { connection, signal } = this.options;
    this.run(() =>
      this.store.reload().catch((error: unknown) => {
        connection.whenRestored(error, signal, () => {
          this.reload();
        });
        throw error;
      }),
    );
  }
}

function timeInput(seconds: number, key: string): HTMLInputElement {
  return element('input', {
    type: 'number',
    min: 0,
    step: 'any',
    value: seconds.toFixed(3),
    'data-key': key,
  });
}
