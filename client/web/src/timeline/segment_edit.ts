// Rules of edited segments: whole frames, inside the clip, without overlap in their track.

import { snapToFrame } from '../motion/motion';

export interface TimedSegment {
  readonly name: string;
  readonly track: string;
  readonly label: string;
  readonly start: number;
  readonly end: number;
}

export type Edge = 'start' | 'end';

export interface TimeRange {
  start: number;
  end: number;
}

// The segment with one edge moved: to a frame, at least one frame long, and not into a neighbour.
export function moveEdge(
  segment: TimedSegment,
  edge: Edge,
  seconds: number,
  others: readonly TimedSegment[],
  duration: number,
  frameRateHz: number,
): TimeRange {
  const frame = 1 / frameRateHz;
  const limits = limitsOf(segment, others, duration);
  const wanted = snapToFrame(seconds, frameRateHz);
  if (edge === 'start') {
    return { start: clamp(wanted, limits.start, segment.end - frame), end: segment.end };
  }
  return { start: segment.start, end: clamp(wanted, segment.start + frame, limits.end) };
}

// The free time of a track around a moment; undefined inside a segment.
export function freeRange(
  track: string,
  seconds: number,
  segments: readonly TimedSegment[],
  duration: number,
): TimeRange | undefined {
  const range = { start: 0, end: duration };
  for (const segment of segments) {
    if (segment.track !== track) continue;
    if (segment.start <= seconds && seconds < segment.end) return undefined;
    if (segment.end <= seconds) range.start = Math.max(range.start, segment.end);
    else range.end = Math.min(range.end, segment.start);
  }
  return range.end > range.start ? range : undefined;
}

// Tracks in order of name, `action` first and always there.
export function tracksOf(segments: readonly TimedSegment[]): string[] {
  const others = new Set(
    segments.map((segment) => segment.track).filter((track) => track !== 'action'),
  );
  return ['action', ...[...others].sort()];
}

// Moments of an axis of `duration` seconds with at most `maxCount` steps of 1, 2 or 5.
export function ticksOf(duration: number, maxCount: number): number[] {
  if (!(duration > 0) || maxCount < 1) return [0];
  const rough = duration / maxCount;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10) * power;
  const ticks: number[] = [];
  for (let index = 0; index * step <= duration * (1 + 1e-9); ++index) ticks.push(index * step);
  return ticks;
}

function limitsOf(
  segment: TimedSegment,
  others: readonly TimedSegment[],
  duration: number,
): TimeRange {
  const limits = { start: 0, end: duration };
  for (const other of others) {
    if (other.name === segment.name || other.track !== segment.track) continue;
    if (other.end <= segment.start + 1e-9) limits.start = Math.max(limits.start, other.end);
    if (other.start >= segment.end - 1e-9) limits.end = Math.min(limits.end, other.start);
  }
  return limits;
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), Math.max(low, high));
}
