import { expect, test } from 'vitest';
import { speedOf } from './player_controls';

test('only the offered speeds are accepted', () => {
  expect(speedOf('0.25')).toBe(0.25);
  for (const text of [null, '', '0', '-1', '1e9', '3', '0.250', 'Infinity'])
    expect(speedOf(text)).toBe(1);
});
