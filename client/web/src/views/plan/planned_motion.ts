import type { Bone, PlannedMotion } from '../../api/messages';
import { copyFrames, createMotion, type Motion } from '../../motion/motion';
import type { FloorPosition } from './floor_geometry';

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
    },
    planned.frameRateHz,
    planned.frameCount,
    false,
    planned.jointNames.length > 0,
  );
  copyFrames(motion.markers, 0, planned.markerPositions);
  copyFrames(motion.joints, 0, planned.jointPositions);
  motion.receivedFrames = planned.frameCount;
  return motion;
}

// The path of the root on the floor.
export function rootPath(planned: PlannedMotion): FloorPosition[] {
  return planned.root.map(({ xM, yM, headingRad }) => ({ x: xM, y: yM, heading: headingRad }));
}
