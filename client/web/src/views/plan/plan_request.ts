import type { MessageInitShape } from '@bufbuild/protobuf';
import { PlanMethod, type FileFormat, type PlanRequestSchema } from '../../api/messages';
import { clipName, databaseName } from '../../api/resource_names';
import { normalAngle, toFrame, type FloorXY } from './floor_geometry';
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
