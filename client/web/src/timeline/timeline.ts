import { element, replaceChildren } from '../dom/element';
import { keepFocus } from '../dom/focus';
import { clock as clockText } from '../dom/format';
import { labelClass } from '../drawing/labels';
import { moveEdge, ticksOf, tracksOf, type Edge, type TimeRange } from './segment_edit';
import type { StoredSegment } from './segment_store';

export interface TimelineEvents {
  seek(seconds: number): void;
  select(segment: StoredSegment | undefined): void;
  // The user has moved an edge.
  move(segment: StoredSegment, change: Partial<TimeRange>): void;
}

const kMaxTicks = 10;

// Segments of a clip by track, over an axis of time, with the present time as a line. Edges of the
// selected segment can be dragged, or moved by arrow keys.
export class Timeline {
  readonly node = element('div', { class: 'timeline', role: 'group', 'aria-label': 'Timeline' });
  private readonly lanes = element('div', { class: 'lanes' });
  private readonly playhead = element('div', { class: 'playhead' });
  // Moved by a transform of its whole width, which needs no layout.
  private readonly playheads = element('div', { class: 'playheads' }, this.playhead);
  private readonly extraRows: HTMLElement[] = [];
  private segments: readonly StoredSegment[] = [];
  private selected = '';
  private zoom = 1;
  private shownTime = -1;
  // The edge that a key moves, or the segment that a pointer drags; nothing is drawn anew meanwhile, but afterwards if
  // something `waiting` has changed.
  private held: HTMLElement | undefined;
  private waiting = false;

  constructor(
    private readonly duration: number,
    private readonly frameRateHz: number,
    private readonly editable: boolean,
    private readonly events: TimelineEvents,
  ) {
    this.node.append(this.lanes);
    this.lanes.addEventListener('pointerdown', (event) => {
      if (event.target instanceof Element && event.target.closest('.segment')) return;
      if (event.button === 0) events.seek(this.timeAt(event.clientX));
    });
  }

  // Adds a row above the segments, such as the contacts of the feet.
  addRow(row: HTMLElement): void {
    row.classList.add('lane');
    this.extraRows.push(row);
    this.draw();
  }

  setSegments(segments: readonly StoredSegment[]): void {
    this.segments = segments;
    this.draw();
  }

  select(name: string): void {
    this.selected = name;
    this.draw();
  }

  // 1 shows the whole clip. The present time moves to the middle.
  setZoom(zoom: number): void {
    this.zoom = Math.min(Math.max(zoom, 1), 50);
    this.lanes.style.width = `${this.zoom * 100}%`;
    this.draw();
    this.reveal();
  }

  // Scrolls the present time to the middle.
  reveal(): void {
    const fraction = Math.max(this.shownTime, 0) / Math.max(this.duration, 1e-9);
    const { clientWidth } = this.node;
    this.node.scrollLeft = fraction * this.lanes.offsetWidth - clientWidth / 2;
  }

  // Moves the line of the present time.
  show(seconds: number): void {
    if (seconds === this.shownTime) return;
    this.shownTime = seconds;
    this.playhead.style.transform = `translateX(${this.percent(seconds)})`;
  }

  private draw(): void {
    this.waiting = this.held !== undefined;
    if (this.waiting) return;
    const axis = element('div', { class: 'axis', 'aria-hidden': 'true' });
    for (const tick of ticksOf(this.duration, kMaxTicks * this.zoom)) {
      const mark = element('span', {}, String(Number(tick.toFixed(2))));
      mark.style.left = this.percent(tick);
      axis.append(mark);
    }
    const rows = tracksOf(this.segments).map((track) => this.rowOf(track));
    keepFocus(this.lanes, () => {
      replaceChildren(this.lanes, axis, ...this.extraRows, ...rows, this.playheads);
    });
  }

  private rowOf(track: string): HTMLElement {
    const lane = element('div', { class: 'lane', role: 'group', 'aria-label': `Track ${track}` });
    lane.append(element('span', { class: 'track-name', 'aria-hidden': 'true' }, track));
    for (const segment of this.segments) {
      if (segment.track === track) lane.append(this.segmentNode(segment));
    }
    return lane;
  }

  private segmentNode(segment: StoredSegment): HTMLElement {
    const selected = segment.name === this.selected;
    const body = element(
      'button',
      {
        type: 'button',
        class: 'segment-body',
        'aria-pressed': selected,
        'data-key': segment.name,
        'aria-label': `${segment.label}, ${clockText(segment.start)} to ${clockText(segment.end)}`,
        title: segment.label,
      },
      segment.label,
    );
    body.setAttribute('aria-pressed', String(selected));
    body.addEventListener('click', (event) => {
      // A click with the pointer also seeks; one by keyboard has no position.
      if (event.detail > 0) this.events.seek(this.timeAt(event.clientX));
      this.events.select(selected ? undefined : segment);
    });
    const node = element('div', { class: `segment ${labelClass(segment.label)}` }, body);
    this.place(node, segment);
    if (selected && this.editable) {
      node.append(this.handle(node, segment, 'start'), this.handle(node, segment, 'end'));
    }
    return node;
  }

  private handle(node: HTMLElement, segment: StoredSegment, edge: Edge): HTMLElement {
    const handle = element('div', {
      class: `edge ${edge}`,
      role: 'slider',
      tabindex: 0,
      'data-key': `${segment.name} ${edge}`,
      'aria-label': edge === 'start' ? 'Start' : 'End',
      'aria-valuemin': 0,
      'aria-valuemax': this.duration.toFixed(3),
      'aria-valuenow': segment[edge].toFixed(3),
      'aria-valuetext': clockText(segment[edge]),
    });
    const moved = (seconds: number) =>
      moveEdge(segment, edge, seconds, this.segments, this.duration, this.frameRateHz);
    let range: TimeRange = { start: segment.start, end: segment.end };
    let sent = range[edge];
    const commit = () => {
      if (this.held !== handle) return;
      this.held = undefined;
      if (range[edge] !== sent) {
        sent = range[edge];
        this.events.move(segment, { [edge]: sent });
      }
      if (this.waiting) this.draw();
    };
    handle.addEventListener('keydown', (event) => {
      const steps: Record<string, number> = {
        ArrowLeft: -1,
        ArrowRight: 1,
        PageDown: -10,
        PageUp: 10,
      };
      const step = steps[event.key];
      if (step === undefined) return;
      event.preventDefault();
      event.stopPropagation();
      // A held key moves the edge many times; the change is stored when the key is released.
      this.held = handle;
      range = moved(range[edge] + step / this.frameRateHz);
      this.place(node, range);
      handle.setAttribute('aria-valuenow', range[edge].toFixed(3));
      handle.setAttribute('aria-valuetext', clockText(range[edge]));
    });
    handle.addEventListener('keyup', commit);
    handle.addEventListener('blur', commit);
    handle.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      event.stopPropagation();
      this.drag(handle, event, node, segment, edge, moved);
    });
    return handle;
  }

  private drag(
    handle: HTMLElement,
    begin: PointerEvent,
    node: HTMLElement,
    segment: StoredSegment,
    edge: Edge,
    moved: (seconds: number) => TimeRange,
  ): void {
    this.held = node; // not the handle, whose change a key would store
    handle.setPointerCapture(begin.pointerId);
    let range: TimeRange = { start: segment.start, end: segment.end };
    const move = (event: PointerEvent) => {
      range = moved(this.timeAt(event.clientX));
      this.place(node, range);
      this.events.seek(range[edge]);
    };
    const end = (event: Event) => {
      handle.removeEventListener('pointermove', move);
      handle.removeEventListener('pointerup', end);
      handle.removeEventListener('pointercancel', end);
      this.held = undefined;
      if (event.type === 'pointerup' && range[edge] !== segment[edge])
        this.events.move(segment, { [edge]: range[edge] });
      else this.waiting = true;
      if (this.waiting) this.draw();
    };
    handle.addEventListener('pointermove', move);
    handle.addEventListener('pointerup', end);
    handle.addEventListener('pointercancel', end);
  }

  private place(node: HTMLElement, range: TimeRange): void {
    node.style.left = this.percent(range.start);
    node.style.width = this.percent(range.end - range.start);
  }

  private percent(seconds: number): string {
    return `${(100 * seconds) / Math.max(this.duration, 1e-9)}%`;
  }

  private timeAt(clientX: number): number {
    const box = this.lanes.getBoundingClientRect();
    const fraction = (clientX - box.left) / Math.max(box.width, 1);
    return Math.min(Math.max(fraction, 0), 1) * this.duration;
  }
}
