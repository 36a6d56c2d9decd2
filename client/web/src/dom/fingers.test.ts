import { expect, test } from 'vitest';
import { Fingers } from './fingers';

test('one finger moves, two also zoom about their middle', () => {
  const fingers = new Fingers();
  expect(fingers.move(1, { x: 9, y: 9 })).toBeUndefined();
  fingers.down(1, { x: 0, y: 0 });
  expect(fingers.move(1, { x: 3, y: -8 })).toEqual({
    x: 3,
    y: -8,
    factor: 1,
    middle: { x: 3, y: -8 },
  });
  fingers.down(2, { x: 13, y: -8 });
  expect(fingers.count).toBe(2);
  expect(fingers.move(2, { x: 23, y: -8 })).toEqual({
    x: 5,
    y: 0,
    factor: 2,
    middle: { x: 13, y: -8 },
  });
  fingers.up(1);
  expect(fingers.count).toBe(1);
  expect(fingers.move(2, { x: 24, y: -8 })?.factor).toBe(1);
});
