import { expect, test } from 'vitest';
import { curvesOf, valueText } from './curves';

// One point in two frames.
const track = { names: ['hand'], bones: [], positions: Float32Array.of(1, 2, 3, NaN, NaN, NaN) };

test('values of a frame are a text', () => {
  const position = curvesOf(track, 0, 'position', 60);
  expect(valueText(position, 0, 'm')).toBe('x 1.000, y 2.000, z 3.000 m');
  expect(valueText(position, 1, 'm')).toBe('missing');
  expect(valueText(curvesOf(track, 0, 'height', 60), 0, 'm')).toBe('z 3.000 m');
  expect(valueText(position, 2, 'm')).toBe('missing');
});
