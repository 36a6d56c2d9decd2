import { describe, expect, it } from 'vitest';
import { Fingers } from '../../dom/fingers';
import {
  fitWindow,
  gridStep,
  keepInside,
  pinchWindow,
  toFloor,
  toPicture,
  zoomAt,
} from './floor_window';

const window = { centre: { x: 1, y: -2 }, scale: 50, width: 600, height: 400 };

describe('keepInside', () => {
  it('moves the picture only to a point outside', () => {
    expect(keepInside(window, { x: 2, y: -3 })).toBe(window);
    const outside = { x: 9, y: -2 };
    expect(keepInside(window, outside)).toEqual({ ...window, centre: outside });
  });
});

describe('toPicture', () => {
  it('is the inverse of toFloor', () => {
    const point = { x: 2.3, y: 0.7 };
    const { left, top } = toPicture(window, point);
    expect(toFloor(window, left, top).x).toBeCloseTo(point.x);
    expect(toFloor(window, left, top).y).toBeCloseTo(point.y);
  });

  it('has the front up and left on the left', () => {
    const origin = toPicture(window, { x: 0, y: 0 });
    expect(toPicture(window, { x: 1, y: 0 })).toEqual({ left: origin.left, top: origin.top - 50 });
    expect(toPicture(window, { x: 0, y: 1 })).toEqual({ left: origin.left - 50, top: origin.top });
  });
});

describe('zoomAt', () => {
  it('keeps the point below the pointer', () => {
    const before = toFloor(window, 120, 330);
    const after = toFloor(zoomAt(window, 1.7, 120, 330), 120, 330);
    expect(after.x).toBeCloseTo(before.x);
    expect(after.y).toBeCloseTo(before.y);
  });

  it('has limits', () => {
    expect(zoomAt(window, 1e9, 0, 0).scale).toBe(4000);
    expect(zoomAt(window, 1e-9, 0, 0).scale).toBe(4);
  });
});

describe('pinchWindow', () => {
  it('keeps the points below two fingers', () => {
    const fingers = new Fingers();
    const places = [
      { x: 100, y: 300 },
      { x: 200, y: 250 },
    ];
    places.forEach((at, i) => {
      fingers.down(i, at);
    });
    const points = places.map(({ x, y }) => toFloor(window, x, y));
    // Along the line between them: two fingers cannot turn the floor.
    const first = pinchWindow(window, fingers.move(1, { x: 300, y: 200 })!);
    const second = pinchWindow(first, fingers.move(0, { x: 0, y: 350 })!);
    expect(second.scale).toBeCloseTo(3 * window.scale);
    const moved = [
      { left: 0, top: 350 },
      { left: 300, top: 200 },
    ];
    points.forEach((point, i) => {
      const { left, top } = toPicture(second, point);
      expect(left).toBeCloseTo(moved[i]!.left);
      expect(top).toBeCloseTo(moved[i]!.top);
    });
  });
});

describe('fitWindow', () => {
  it('shows all points', () => {
    const points = [
      { x: 5, y: 3 },
      { x: -2, y: -9 },
    ];
    const fitted = fitWindow(points, 500, 300);
    for (const point of [...points, { x: 0, y: 0 }]) {
      const { left, top } = toPicture(fitted, point);
      expect(left).toBeGreaterThan(0);
      expect(left).toBeLessThan(500);
      expect(top).toBeGreaterThan(0);
      expect(top).toBeLessThan(300);
    }
  });
});

describe('gridStep', () => {
  it('is round and at least 40 px', () => {
    for (const scale of [4, 13, 50, 77, 400, 4000]) {
      const step = gridStep({ ...window, scale });
      expect(step * scale).toBeGreaterThanOrEqual(39.9);
      expect(step * scale).toBeLessThanOrEqual(101);
    }
  });
});
