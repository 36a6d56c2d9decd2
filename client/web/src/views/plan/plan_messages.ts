import type { MessageInitShape } from '@bufbuild/protobuf';
import {
  PlanMethod,
  type FileFormat,
  type PlanRequestSchema,
  type Bone,
  type PlannedMotion,
} from '../../api/messages';
import { clipName, databaseName } from '../../api/resource_names';
import { copyFrames, copyRotations, createMotion, type Motion } from '../../motion/motion';
import {
  normalAngle,
  toFrame,
  type FloorXY,
  fromFrame,
  type FloorPosition,
} from './floor_geometry';
import type { PlanSettings } from './plan_settings';

export type PlanRequestInit = MessageInitShape<typeof PlanRequestSchema>;

// A robot that performs the motion.
export interface Robot {
  fileName: string;
  urdf: Uint8Array;
}

// The request of a plan, in the frame of its start. With a format, its motions are also files: the same seed gives the same
// motions again.
export function planRequest(
  database: string,
  settings: PlanSettings,
  robot: Robot | undefined,
  format?: FileFormat,
): PlanRequestInit {
  const { clip, time, start, goal, obstacles, alternatives, seed, filter, paper } = settings;
  const point = (place: FloorXY) => {
    const { x, y } = toFrame(start, place);
    return { xM: x, yM: y };
  };
  const discs = obstacles.flatMap((shape) =>
    shape.kind === 'disc' ? [{ centre: point(shape.centre), radiusM: shape.radius }] : [],
  );
  const polygons = obstacles.flatMap((shape) =>
    shape.kind === 'polygon' ? [{ corners: shape.corners.map(point) }] : [],
  );
  return {
    database: databaseName(database),
    goal: { ...point(goal), headingRad: normalAngle(goal.heading - start.heading) },
    alternativeCount: alternatives,
    seed,
    filter,
    method: paper ? PlanMethod.RANDOM_SAMPLING : PlanMethod.SEGMENT_SEARCH,
    ...(clip === ''
      ? {}
      : { start: { case: 'clipStart', value: { clip: clipName(database, clip), seconds: time } } }),
    ...(obstacles.length > 0 ? { obstacles: { discs, polygons } } : {}),
    ...(robot ? { body: { case: 'robot', value: robot } } : {}),
    ...(format === undefined ? {} : { includeFiles: true, fileFormat: format }),
  };
}

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
