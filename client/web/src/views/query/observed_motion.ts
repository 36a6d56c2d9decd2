import type { MessageInitShape } from '@bufbuild/protobuf';
import type { Api } from '../../api/api';
import type { ObservationSchema } from '../../api/messages';
import { clipName, databaseName } from '../../api/resource_names';
import { readFile } from '../../dom/file_bytes';
import { floatBytes } from '../../drawing/float_bytes';
import { copyFrames, createMotion, type Motion } from '../../motion/motion';
import { completeMotion } from '../../motion/motion_reader';
import { cutMotion, type MarkerMotion } from './marker_error';

export type ObservationInit = MessageInitShape<typeof ObservationSchema>;

// A motion that is asked about, as positions of the markers of the database.
export interface ObservedMotion {
  name: string;
  motion: Motion;
  legLengthM: number | undefined;
}

// Part of a stored clip, in s; undefined: its start, its end.
export async function observeClip(
  api: Api,
  database: string,
  clip: string,
  from: number | undefined,
  to: number | undefined,
  signal: AbortSignal,
): Promise<ObservedMotion> {
  const name = clipName(database, clip);
  const stored = (await api.clips.getClip({ name }, { signal })).clip;
  if (!stored) throw new Error(`Expected the clip '${clip}', got none.`);
  const rate = stored.frameCount / Math.max(stored.durationSeconds, 1e-9);
  const firstFrame = Math.min(Math.round((from ?? 0) * rate), Math.max(0, stored.frameCount - 1));
  const end = to === undefined ? stored.frameCount : Math.round(to * rate) + 1;
  const frameCount = Math.max(1, Math.min(end, stored.frameCount) - firstFrame);
  let motion: Motion | undefined;
  const stream = api.views.readClipMotion({ name, firstFrame, frameCount }, { signal });
  for await (const block of stream) {
    if (!motion) {
      if (!block.figure) throw new Error('Expected the figure in the first message, got none.');
      motion = createMotion(name, block.figure, block.frameRateHz, frameCount, false, false);
    }
    copyFrames(motion.markers, block.firstFrame - firstFrame, block.markerPositions);
    motion.receivedFrames += block.frameCount;
  }
  return { name: clip, motion: completeMotion(motion), legLengthM: stored.legLengthM };
}

// A motion file, with its skeleton file if it needs one: an ASF or URDF file among `files`.
export async function observeFiles(
  api: Api,
  database: string,
  files: readonly File[],
  signal: AbortSignal,
): Promise<ObservedMotion> {
  const skeleton = files.find((file) => isSkeleton(file.name));
  const file = files.find((other) => other !== skeleton);
  if (!file) throw new Error('Expected a motion file, got only a skeleton: add the motion file.');
  const observation: ObservationInit = {
    form: {
      case: 'file',
      value: {
        fileName: file.name,
        data: await readFile(file),
        ...(skeleton
          ? { skeletonFileName: skeleton.name, skeletonData: await readFile(skeleton) }
          : {}),
      },
    },
  };
  const name = databaseName(database);
  const [response, figure] = await Promise.all([
    api.observe.represent({ database: name, observation }, { signal }),
    api.views.getFigure({ name }, { signal }),
  ]);
  const { markers } = response;
  if (!markers || !figure.figure) throw new Error('Expected the markers of the file, got none.');
  const { frameRateHz, frameCount } = markers;
  const motion = createMotion(file.name, figure.figure, frameRateHz, frameCount, false, false);
  copyFrames(motion.markers, 0, markers.positions);
  motion.receivedFrames = frameCount;
  return { name: file.name, motion, legLengthM: markers.legLengthM };
}

// The markers of a motion, without their names.
export function markersOf({ motion }: ObservedMotion): MarkerMotion {
  return {
    frameRateHz: motion.frameRateHz,
    markerCount: motion.markers.names.length,
    positions: motion.markers.positions,
  };
}

// The observation for a query: all of the motion, or its part [from, to] in s.
export function observationOf(
  observed: ObservedMotion,
  part?: { from: number; to: number },
): ObservationInit {
  const all = markersOf(observed);
  const { positions, markerCount } = part ? cutMotion(all, part.from, part.to) : all;
  return {
    form: {
      case: 'markers',
      value: {
        frameRateHz: all.frameRateHz,
        frameCount: positions.length / (3 * markerCount),
        positions: floatBytes(positions),
        ...(observed.legLengthM === undefined ? {} : { legLengthM: observed.legLengthM }),
      },
    },
  };
}

function isSkeleton(name: string): boolean {
  return /\.(asf|urdf|xml)(\.gz)?$/i.test(name);
}
