import { expect, test } from 'vitest';
import { sideOf } from './figure_shape';
import { footPoints } from './contact_object';
import { extentOf, floorLines } from './floor_object';
import { percentile } from './scene';
import { fillTrails } from './trail_object';

test('knows the side of common names', () => {
  for (const name of [
    'LHip',
    'LeftFoot',
    'l_thigh',
    'mixamorig:LeftHand',
    'hip_l',
    'lfemur',
    'left_knee',
  ]) {
    expect(sideOf(name), name).toBe('left');
  }
  for (const name of ['RHip', 'RightFoot', 'r_thigh', 'hand.R', 'rtibia', 'right_knee']) {
    expect(sideOf(name), name).toBe('right');
  }
  for (const name of ['Pelvis', 'Head', 'lowerback', 'root', 'Spine', 'thorax']) {
    expect(sideOf(name), name).toBe('middle');
  }
});

test('finds the markers of a foot', () => {
  expect(footPoints(['LHip', 'LAnkle', 'RAnkle', 'LToe'], 'left')).toEqual([1, 3]);
});

test('the floor covers a motion with a margin, and is bounded', () => {
  const positions = Float32Array.from([0, 0, 1, NaN, NaN, NaN, 4.5, -2, 1]);
  expect(extentOf(positions)).toEqual({ minX: 0, minY: -2, maxX: 4.5, maxY: 0 });
  const lines = floorLines(extentOf(positions));
  expect(Math.min(...lines)).toBe(-3);
  expect(Math.max(...lines)).toBe(6);
  expect(floorLines({ minX: -1e6, maxX: 1e6, minY: 0, maxY: 1 }).length).toBeLessThan(2000);
  expect(extentOf(new Float32Array([NaN, NaN, NaN])).minX).toBe(-2);
});

test('trails end at the present frame and skip missing points', () => {
  const positions = Float32Array.from({ length: 10 * 3 }, (_, index) => Math.floor(index / 3));
  positions[3 * 5] = NaN;
  const track = { names: ['p'], bones: [], positions };
  const values = new Float32Array(60 * 6);
  const end = fillTrails(values, track, [0], 9, 9);
  // 9 steps, two of them at the missing frame 5.
  expect(end).toBe(7 * 6);
  expect([...values.subarray(0, 6)]).toEqual([8, 8, 8, 9, 9, 9]);
  expect(fillTrails(values, track, [0], 0, 9)).toBe(0);
});

test('percentiles', () => {
  expect(percentile([], 0.95)).toBe(0);
  expect(percentile([5, 1, 4, 2, 3], 0.95)).toBe(5);
  expect(percentile([5, 1, 4, 2, 3], 0.5)).toBe(3);
});
