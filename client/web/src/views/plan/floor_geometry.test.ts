import { describe, expect, it } from 'vitest';
import {
  contains,
  headingOf,
  normalAngle,
  obstacleText,
  placesEvery,
  placeText,
  polygonError,
  poseText,
} from './floor_geometry';

const xy = (...values: [number, number][]) => values.map(([x, y]) => ({ x, y }));

describe('headingOf', () => {
  it('is 0 to the front and positive to the left', () => {
    expect(headingOf({ x: 1, y: 1 }, { x: 2, y: 1 })).toBe(0);
    expect(headingOf({ x: 0, y: 0 }, { x: 0, y: 1 })).toBeCloseTo(Math.PI / 2);
  });

  it('is undefined for a click', () => {
    expect(headingOf({ x: 0, y: 0 }, { x: 0.01, y: 0 })).toBeUndefined();
  });
});

describe('texts of places', () => {
  it('have no negative zero', () => {
    expect(placeText({ x: -0.04, y: 1.26 })).toBe('0.0 m ahead, 1.3 m to the left');
    expect(poseText({ x: -1, y: 0, heading: -0.001 })).toBe(
      '-1.0 m ahead, 0.0 m to the left, heading 0 degrees',
    );
  });

  it('tell the obstacle', () => {
    const disc = { kind: 'disc', centre: { x: 1, y: 2 }, radius: 0.35 } as const;
    expect(obstacleText(disc)).toBe('Disc, radius 0.35 m, 1.0 m ahead, 2.0 m to the left');
    expect(obstacleText({ kind: 'polygon', corners: xy([0, 1], [1, 1], [1, 2]) })).toMatch(
      /^Polygon, 3 corners/,
    );
  });
});

describe('normalAngle', () => {
  it('keeps the direction', () => {
    for (let angle = -20; angle < 20; angle += 0.37) {
      const normal = normalAngle(angle);
      expect(normal).toBeGreaterThan(-Math.PI);
      expect(normal).toBeLessThanOrEqual(Math.PI);
      expect(Math.cos(normal)).toBeCloseTo(Math.cos(angle));
      expect(Math.sin(normal)).toBeCloseTo(Math.sin(angle));
    }
  });
});

describe('contains', () => {
  const shape = { kind: 'polygon' as const, corners: xy([0, 0], [4, 0], [4, 4], [2, 1], [0, 4]) };

  it('knows the inside of a concave polygon', () => {
    expect(contains(shape, { x: 0.5, y: 2 })).toBe(true);
    expect(contains(shape, { x: 2, y: 2 })).toBe(false);
    expect(contains(shape, { x: 5, y: 1 })).toBe(false);
  });

  it('knows the inside of a disc', () => {
    const disc = { kind: 'disc' as const, centre: { x: 1, y: 1 }, radius: 0.5 };
    expect(contains(disc, { x: 1.5, y: 1 })).toBe(true);
    expect(contains(disc, { x: 1.4, y: 1.4 })).toBe(false);
  });
});

describe('polygonError', () => {
  it('accepts simple polygons in both directions', () => {
    const corners = xy([0, 0], [4, 0], [4, 4], [2, 1], [0, 4]);
    expect(polygonError(corners)).toBe('');
    expect(polygonError([...corners].reverse())).toBe('');
    expect(polygonError(xy([0, 0], [1, 0], [0, 1]))).toBe('');
  });

  it('rejects crossing, touching and folded edges', () => {
    expect(polygonError(xy([0, 0], [1, 1], [1, 0], [0, 1]))).toMatch(/cross/);
    expect(polygonError(xy([0, 0], [4, 0], [4, 4], [2, 0], [0, 4]))).toMatch(/cross/);
    expect(polygonError(xy([0, 0], [2, 0], [1, 0]))).toMatch(/cross/);
    expect(polygonError(xy([0, 0], [0, 0], [1, 0], [1, 1]))).toMatch(/equal/);
    expect(polygonError(xy([0, 0], [1, 1]))).toMatch(/3 corners/);
  });
});

describe('placesEvery', () => {
  it('takes a place each 1/6 s and the last one', () => {
    const path = Array.from({ length: 65 }, (_, i) => i);
    expect(placesEvery(path, 60)).toEqual([0, 10, 20, 30, 40, 50, 60, 64]);
    expect(placesEvery(path.slice(0, 61), 60)).toEqual([0, 10, 20, 30, 40, 50, 60]);
    expect(placesEvery([], 60)).toEqual([]);
  });
});
