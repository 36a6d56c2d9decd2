import { describe, expect, test } from 'vitest';
import { rangeAfterKey, pinchedRange, type ChartRange, zoomByWheel } from './chart_zoom';

describe('zoom by keys', () => {
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
});

describe('zoom by two fingers', () => {
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
});

describe('zoom by the wheel', () => {
  const all = { min: 0, max: 10 };

  // A picture of 100 px that shows `first`; the result turns the wheel at a place.
  function openPicture(first: ChartRange) {
    const node = document.createElement('div');
    node.getBoundingClientRect = () => ({ left: 20, width: 100 }) as DOMRect;
    let shown = first;
    zoomByWheel(node, { ranges: () => ({ shown, all }), show: (range) => (shown = range) });
    return (clientX: number, change: WheelEventInit) => {
      const event = new WheelEvent('wheel', { clientX, cancelable: true, ...change });
      node.dispatchEvent(event);
      return { ...shown, taken: event.defaultPrevented };
    };
  }

  test('the wheel zooms about the pointer', () => {
    const turn = openPicture(all);
    const near = turn(50, { deltaY: -500 * Math.log(2) });
    expect(near.min).toBeCloseTo(1.5, 9);
    expect(near.max).toBeCloseTo(6.5, 9);
    expect(near.taken).toBe(true);
    const back = turn(50, { deltaY: 5000 });
    expect([back.min, back.max]).toEqual([0, 10]);
    // All is shown: the page scrolls.
    expect(turn(50, { deltaY: 100 }).taken).toBe(false);
  });

  test('with Shift or sideways it moves, not over the ends', () => {
    for (const change of [{ deltaY: 50, shiftKey: true }, { deltaX: 50 }]) {
      const turn = openPicture({ min: 2, max: 6 });
      const moved = turn(20, change);
      expect(moved.min).toBeCloseTo(4, 9);
      expect(moved.max).toBeCloseTo(8, 9);
      for (let i = 0; i < 3; ++i) turn(20, change);
      expect(turn(20, change)).toEqual({ min: 6, max: 10, taken: false });
    }
  });
});
