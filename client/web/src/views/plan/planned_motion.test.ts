import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { PlannedMotionSchema, VisualGeometry } from '../../api/messages';
import { floatBytes } from '../../drawing/float_bytes';
import { frameOf, rotationsOf } from '../../motion/motion';
import { stageMotion } from './planned_motion';

test('a planned motion of a robot has its joints and their shapes', () => {
  const planned = create(PlannedMotionSchema, {
    frameRateHz: 60,
    frameCount: 2,
    markerNames: ['head'],
    markerPositions: floatBytes(Float32Array.from([1, 2, 3, 4, 5, 6])),
    jointNames: ['base'],
    jointPositions: floatBytes(Float32Array.from([0, 0, 1, 0, 0, 2])),
    jointVisuals: [{ joint: 0, geometry: VisualGeometry.SPHERE, sizeM: [1, 1, 1] }],
    jointRotations: floatBytes(Float32Array.from([0, 0, 0, 1, 0, 0, 1, 0])),
  });
  const motion = stageMotion('plan', planned, []);
  expect(motion.receivedFrames).toBe(2);
  expect([...frameOf(motion.markers, 1)]).toEqual([4, 5, 6]);
  expect([...frameOf(motion.joints, 1)]).toEqual([0, 0, 2]);
  expect([...rotationsOf(motion.joints, 1)]).toEqual([0, 0, 1, 0]);
  expect(motion.joints.visuals.map(({ geometry }) => geometry)).toEqual([VisualGeometry.SPHERE]);
});
