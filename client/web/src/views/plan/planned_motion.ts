import type { Bone, PlannedMotion } from '../../api/messages';
import { copyFrames, copyRotations, createMotion, type Motion } from '../../motion/motion';
import { fromFrame, normalAngle, type FloorPosition } from './floor_geometry';

// A planned motion for the stage: markers with the bones of the database's figure, and the joints of
// the body, a stored skeleton or a robot.
export function stageMotion(name: string, planned: PlannedMotion, bones: readonly Bone[]): Motion {
  const motion = createMotion(
    name,
    {
      $typeName: 'motiondb.v1.Figure',
      markerNames: planned.markerNames,
      markerBones: [...bones],
      jointNames: planned.jointNames,
      jointBones: planned.jointBones,
      jointVisuals: planned.jointVisuals,
    },
    planned.frameRateHz,
    planned.frameCount,
    false,
    planned.jointNames.length > 0,
  );
  copyFrames(motion.markers, 0, planned.markerPositions);
  copyFrames(motion.joints, 0, planned.jointPositions);
  copyRotations(motion.joints, 0, planned.jointRotations);
  motion.receivedFrames = planned.frameCount;
  return motion;
}

// The path of the root on the floor, for a motion that was planned from `start`.
export function rootPath(planned: PlannedMotion, start: FloorPosition): FloorPosition[] {
  return planned.root.map(({ xM, yM, headingRad }) => ({
    ...fromFrame(start, { x: xM, y: yM }),
    heading: normalAngle(start.heading + headingRad),
  }));
}

// True if both motions have the same markers in each frame.
export function isSameMotion(one: PlannedMotion, other: PlannedMotion): boolean {
  const [a, b] = [one.markerPositions, other.markerPositions];
  return a.length === b.length && a.every((byte, i) => byte === b[i]);
}
