import { expect, test, vi } from 'vitest';
import { SegmentSource } from '../api/messages';
import type { StoredSegment } from './segment_store';
import { Timeline } from './timeline';

const kHostile = '<img src=x onerror="alert(1)"><script>alert(2)</script>';

function segment(label: string): StoredSegment {
  return {
    name: 'databases/d/clips/c/segments/s',
    track: 'action',
    label,
    start: 1,
    end: 2,
    etag: 'e',
    source: SegmentSource.PERSON,
    confidence: 1,
    author: '',
  };
}

function openTimeline() {
  const events = { seek: vi.fn(), select: vi.fn(), move: vi.fn() };
  const timeline = new Timeline(10, 60, true, events);
  document.body.replaceChildren(timeline.node);
  return { timeline, events };
}

test('a label is text, never HTML', () => {
  const { timeline } = openTimeline();
  timeline.setSegments([segment(kHostile)]);
  expect(timeline.node.querySelector('img, script')).toBeNull();
  expect(timeline.node.textContent).toContain(kHostile);
});

test('arrow keys move the edge of the selected segment by frames, stored at their release', () => {
  const { timeline, events } = openTimeline();
  const stored = segment('walk');
  timeline.setSegments([stored]);
  timeline.select(stored.name);
  const edge = timeline.node.querySelector('.edge.end');
  const press = (kind: 'keydown' | 'keyup') =>
    edge?.dispatchEvent(new KeyboardEvent(kind, { key: 'ArrowRight', bubbles: true }));
  for (let i = 0; i < 3; ++i) press('keydown');
  expect(events.move).not.toHaveBeenCalled();
  expect(edge?.getAttribute('aria-valuenow')).toBe('2.050');
  // Changes that arrive meanwhile are drawn at the end; the edge that goes then stores nothing again.
  timeline.setSegments([{ ...stored, etag: 'other' }]);
  expect(edge?.isConnected).toBe(true);
  press('keyup');
  edge?.dispatchEvent(new Event('blur'));
  expect(edge?.isConnected).toBe(false);
  expect(events.move).toHaveBeenCalledOnce();
  const [, change] = events.move.mock.calls[0] as [StoredSegment, { end: number }];
  expect(Object.keys(change)).toEqual(['end']); // the other edge can be moved by another client
  expect(change.end).toBeCloseTo(2 + 3 / 60, 9);
});

test('a click selects a segment, a second one deselects it', () => {
  const { timeline, events } = openTimeline();
  const stored = segment('walk');
  timeline.setSegments([stored]);
  timeline.node.querySelector<HTMLElement>('.segment-body')?.click();
  expect(events.select).toHaveBeenLastCalledWith(stored);
  timeline.select(stored.name);
  timeline.node.querySelector<HTMLElement>('.segment-body')?.click();
  expect(events.select).toHaveBeenLastCalledWith(undefined);
});

test('an edge that goes back before the answer is stored where it was', () => {
  const { timeline, events } = openTimeline();
  const stored = segment('walk');
  timeline.setSegments([stored]);
  timeline.select(stored.name);
  const edge = timeline.node.querySelector('.edge.start');
  for (const key of ['ArrowRight', 'ArrowLeft'])
    for (const kind of ['keydown', 'keyup'])
      edge?.dispatchEvent(new KeyboardEvent(kind, { key, bubbles: true }));
  const starts = events.move.mock.calls.map(([, change]: { start: number }[]) => change?.start);
  expect(starts.map((start) => start?.toFixed(4))).toEqual(['1.0167', '1.0000']);
});

test('changes that arrive while an edge is dragged do not end the drag', () => {
  const { timeline, events } = openTimeline();
  const stored = segment('walk');
  timeline.setSegments([stored]);
  timeline.select(stored.name);
  const edge = timeline.node.querySelector<HTMLElement>('.edge.end')!;
  edge.setPointerCapture = () => undefined;
  // The timeline is one px wide and 10 s long.
  const point = (kind: string, clientX: number) =>
    edge.dispatchEvent(new MouseEvent(kind, { clientX, bubbles: true }));
  point('pointerdown', 0.2);
  point('pointermove', 0.3);
  timeline.setSegments([{ ...stored, etag: 'other' }]);
  edge.dispatchEvent(new Event('blur'));
  expect(edge.isConnected).toBe(true);
  expect(events.move).not.toHaveBeenCalled();
  point('pointerup', 0.3);
  expect(events.move).toHaveBeenCalledWith(stored, { end: 3 });
  expect(edge.isConnected).toBe(false);
});
