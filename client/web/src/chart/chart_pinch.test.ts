import { expect, test } from 'vitest';
import { pinchedRange } from './chart_pinch';

const all = { min: 0, max: 10 };

test('what is under the fingers stays under them', () => {
  // Of 100 px for 0 to 10 s: 4 s and 6 s go to 20 and 80 px.
  const { min, max } = pinchedRange(all, [40, 60], [20, 80], 100, all);
  const valueAt = (pixel: number) => min + ((max - min) * pixel) / 100;
  expect(valueAt(20)).toBeCloseTo(4, 9);
  expect(valueAt(80)).toBeCloseTo(6, 9);
});

test('fingers that move together move the range, not over its ends', () => {
  const range = { min: 2, max: 4 };
  const moved = pinchedRange(range, [40, 60], [30, 50], 100, all);
  expect(moved.min).toBeCloseTo(2.2, 9);
  expect(moved.max).toBeCloseTo(4.2, 9);
  expect(pinchedRange(range, [40, 60], [90, 110], 20, all)).toEqual({ min: 0, max: 2 });
  expect(pinchedRange(all, [40, 60], [45, 50], 100, all)).toEqual(all);
});

test('fingers that meet or pass each other change nothing', () => {
  expect(pinchedRange(all, [40, 60], [50, 50], 100, all)).toEqual(all);
  expect(pinchedRange(all, [40, 60], [60, 40], 100, all)).toEqual(all);
});
