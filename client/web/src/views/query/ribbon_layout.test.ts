import { describe, expect, it } from 'vitest';
import { columnsOf, ribbonAreas, runsOf, windowAt, type LabelledWindow } from './ribbon_layout';

function windows(
  ...probabilities: [walk: number, jump: number, unknown?: number][]
): LabelledWindow[] {
  return probabilities.map(([walk, jump, unknownProbability], i) => ({
    startSeconds: 0.1 * i,
    endSeconds: 0.1 * i + 0.4,
    familiarity: 0.5,
    unknownProbability,
    labels: [
      { label: 'walk', probability: walk },
      { label: 'jump', probability: jump },
    ].sort((a, b) => b.probability - a.probability) as LabelledWindow['labels'],
  }));
}

const observed = windows([0.7, 0.1, 0.2], [0.6, 0.3, 0.1], [0.2, 0.2, 0.6], [0.1, 0.9]);

describe('columnsOf', () => {
  it('covers the observation without gaps or overlaps', () => {
    const columns = columnsOf(observed);
    expect(columns[0]![0]).toBe(0);
    expect(columns.at(-1)![1]).toBeCloseTo(0.7);
    columns.slice(1).forEach(([start], i) => {
      expect(start).toBe(columns[i]![1]);
    });
  });
});

describe('ribbonAreas', () => {
  const areas = ribbonAreas(observed, ['jump', 'walk']);

  it('fills each column to the sum of its probabilities', () => {
    for (const [start] of columnsOf(observed)) {
      const column = areas.filter((area) => area.startSeconds === start);
      expect(column.at(-1)!.top).toBeCloseTo(1);
      column.slice(1).forEach((area, i) => {
        expect(area.bottom).toBe(column[i]!.top);
      });
    }
  });

  it('keeps the order of the labels, unknown motion at the bottom', () => {
    expect(areas.slice(0, 3).map((area) => area.label)).toEqual(['', 'jump', 'walk']);
    expect(areas[0]).toMatchObject({ unknown: true, bottom: 0, top: 0.2 });
    expect(areas.filter((area) => area.unknown)).toHaveLength(3);
  });
});

describe('runsOf', () => {
  it('joins columns with the same winner', () => {
    const runs = runsOf(observed);
    expect(runs.map(({ label, unknown }) => (unknown ? '?' : label))).toEqual([
      'walk',
      '?',
      'jump',
    ]);
    expect(runs[0]!.probability).toBeCloseTo(0.65);
    expect(runs[0]!.endSeconds).toBe(runs[1]!.startSeconds);
  });

  it('is empty without windows', () => {
    expect(runsOf([])).toEqual([]);
    expect(windowAt([], 1)).toBe(-1);
  });
});

describe('windowAt', () => {
  it('finds the column of a time', () => {
    expect(windowAt(observed, -1)).toBe(0);
    expect(windowAt(observed, 0.3)).toBe(1);
    expect(windowAt(observed, 99)).toBe(3);
  });
});
