import { expect, test } from 'vitest';
import { rangeAfterKey } from './chart_keys';

const all = { min: 0, max: 9 };

test('plus and minus zoom about the place', () => {
  const near = rangeAfterKey('+', all, 3, all)!;
  expect(near.min).toBeCloseTo(1, 9);
  expect(near.max).toBeCloseTo(7, 9);
  expect(rangeAfterKey('=', all, 3, all)).toEqual(near);
  const back = rangeAfterKey('-', near, 3, all)!;
  expect(back.min).toBeCloseTo(0, 9);
  expect(back.max).toBeCloseTo(9, 9);
});

test('without a place in the range they zoom about the middle', () => {
  for (const place of [NaN, 8]) {
    const near = rangeAfterKey('+', { min: 0, max: 6 }, place, all)!;
    expect(near.min).toBeCloseTo(1, 9);
    expect(near.max).toBeCloseTo(5, 9);
  }
});

test('the range does not become larger than all, which zero shows', () => {
  expect(rangeAfterKey('-', all, 3, all)).toEqual(all);
  expect(rangeAfterKey('0', { min: 2, max: 3 }, NaN, all)).toEqual(all);
  expect(rangeAfterKey('1', all, 3, all)).toBeUndefined();
});
