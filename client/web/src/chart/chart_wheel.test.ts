import { expect, test } from 'vitest';
import type { ChartRange } from './chart_range';
import { zoomByWheel } from './chart_wheel';

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
