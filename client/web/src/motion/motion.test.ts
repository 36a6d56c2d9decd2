import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { FigureSchema } from '../api/messages';
import { alignmentOffset } from './alignment';
import { curvesOf } from './curves';
import { copyFrames, createMotion, floatsOf, frameAt, frameOf, type Motion } from './motion';

const figure = create(FigureSchema, { markerNames: ['a', 'b'] });

function motionOf(height: (time: number) => number, seconds: number, rate = 60): Motion {
  const motion = createMotion('m', figure, rate, Math.round(seconds * rate), false, false);
  for (let frame = 0; frame < motion.frameCount; ++frame) {
    const z = height(frame / rate);
    motion.markers.positions.set([frame / rate, 0, z, 0, 2 * (frame / rate), z * z], frame * 6);
  }
  return motion;
}

test('frames arrive at any address and in any block', () => {
  const motion = createMotion('m', figure, 60, 3, true, false);
  expect(motion.contacts.length).toBe(3);
  const values = Float32Array.from({ length: 12 }, (_, index) => index);
  // One byte before, so that the values are not aligned.
  const bytes = new Uint8Array(1 + values.byteLength);
  bytes.set(new Uint8Array(values.buffer), 1);
  copyFrames(motion.markers, 1, bytes.subarray(1));
  expect([...frameOf(motion.markers, 1)]).toEqual([0, 1, 2, 3, 4, 5]);
  expect([...frameOf(motion.markers, 2)]).toEqual([6, 7, 8, 9, 10, 11]);
  expect([...frameOf(motion.markers, 0)].every(Number.isNaN)).toBe(true);
  copyFrames(motion.markers, 2, bytes.subarray(1));
  copyFrames(motion.markers, 9, bytes.subarray(1));
  expect([...floatsOf(bytes.subarray(1))]).toEqual([...values]);
});

test('a time shows the last frame that has begun', () => {
  const motion = motionOf(() => 1, 1);
  expect(frameAt(motion, -1)).toBe(0);
  expect(frameAt(motion, 0.0166)).toBe(0);
  expect(frameAt(motion, 0.0167)).toBe(1);
  expect(frameAt(motion, 99)).toBe(59);
});

test('curves are the positions and their speed', () => {
  const motion = motionOf(() => 1, 1);
  const [x, y, z] = curvesOf(motion.markers, 0, 'position', 60);
  expect(x?.values[30]).toBeCloseTo(0.5, 6);
  expect(y?.values[30]).toBe(0);
  expect(z?.values[30]).toBe(1);
  const [speed] = curvesOf(motion.markers, 1, 'speed', 60);
  for (const frame of [0, 30, 59]) expect(speed?.values[frame]).toBeCloseTo(2, 4);
});

test('finds by how much a motion is later', () => {
  const height = (time: number) => 1 + Math.sin(time * 2) + 0.3 * Math.sin(time * 5.1);
  for (const delay of [-1.2, 0, 0.8]) {
    const offset = alignmentOffset(
      motionOf(height, 8),
      motionOf((time) => height(time - delay), 8),
    );
    expect(offset).toBeCloseTo(delay, 1);
  }
});
