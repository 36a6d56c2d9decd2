import { expect, test } from 'vitest';
import { snapToFrame } from '../motion/motion';
import { freeRange, moveEdge, ticksOf, tracksOf, type TimedSegment } from './segment_edit';

function segment(name: string, start: number, end: number, track = 'action'): TimedSegment {
  return { name, track, label: name, start, end };
}

const kRate = 60;
const kDuration = 10;
const all = [
  segment('a', 1, 2),
  segment('b', 3, 5),
  segment('c', 7, 9),
  segment('other', 0, 10, 'carries'),
];

test('a moved edge stays on frames, in the clip and out of the neighbours', () => {
  for (const moved of all.slice(0, 3)) {
    for (const edge of ['start', 'end'] as const) {
      for (let seconds = -1; seconds <= 11; seconds += 0.137) {
        const range = moveEdge(moved, edge, seconds, all, kDuration, kRate);
        expect(range.end - range.start).toBeGreaterThan(0.99 / kRate);
        expect(range.start).toBeGreaterThanOrEqual(0);
        expect(range.end).toBeLessThanOrEqual(kDuration);
        for (const other of all) {
          if (other.name === moved.name || other.track !== 'action') continue;
          expect(range.end <= other.start + 1e-9 || range.start >= other.end - 1e-9).toBe(true);
        }
      }
    }
  }
});

test('an edge goes where it is put if that is free', () => {
  expect(moveEdge(segment('b', 3, 5), 'end', 6.001, all, kDuration, kRate)).toEqual({
    start: 3,
    end: 6,
  });
});

test('finds the free time around a moment', () => {
  expect(freeRange('action', 2.5, all, kDuration)).toEqual({ start: 2, end: 3 });
  expect(freeRange('action', 0, all, kDuration)).toEqual({ start: 0, end: 1 });
  expect(freeRange('action', 4, all, kDuration)).toBeUndefined();
  expect(freeRange('new', 4, all, kDuration)).toEqual({ start: 0, end: 10 });
});

test('the track of actions is first and always there', () => {
  expect(tracksOf([])).toEqual(['action']);
  expect(tracksOf([segment('x', 0, 1, 'zebra'), segment('y', 0, 1, 'ape')])).toEqual([
    'action',
    'ape',
    'zebra',
  ]);
});

test('ticks are round, few and inside', () => {
  for (const duration of [0.1, 1, 7.3, 166.7, 3600]) {
    const ticks = ticksOf(duration, 10);
    expect(ticks.length).toBeGreaterThan(2);
    expect(ticks.length).toBeLessThanOrEqual(11);
    expect(ticks[0]).toBe(0);
    expect(ticks.at(-1)).toBeLessThanOrEqual(duration * 1.0001);
  }
  expect(ticksOf(10, 10).slice(0, 3)).toEqual([0, 1, 2]);
});

test('snaps to frames', () => {
  expect(snapToFrame(0.51, 10)).toBe(0.5);
});
