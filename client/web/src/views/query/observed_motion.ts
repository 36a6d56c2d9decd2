import type { MessageInitShape } from '@bufbuild/protobuf';
import type { Api } from '../../api/api';
import type { ObservationSchema } from '../../api/messages';
import { clipName, databaseName } from '../../api/resource_names';
import { readFile } from '../../dom/files';
import { floatBytes, copyFrames, createMotion, type Motion } from '../../motion/motion';
import { completeMotion } from '../../motion/motion_reader';

// Marker positions of a motion: frames x markers x 3, m.
export interface MarkerMotion {
  frameRateHz: number;
  markerCount: number;
  positions: Float32Array;
}

// Number of frames of a motion.
export function frameCountOf(motion: MarkerMotion): number {
  return motion.markerCount > 0 ? motion.positions.length / (3 * motion.markerCount) : 0;
}

// Time of the last frame, s.
export function lastSecondOf(motion: MarkerMotion): number {
  return Math.max(0, frameCountOf(motion) - 1) / motion.frameRateHz;
}

// Pose at a time, linear between frames; undefined outside the motion.
export function poseAt(motion: MarkerMotion, seconds: number): Float32Array | undefined {
  const count = frameCountOf(motion);
  const at = seconds * motion.frameRateHz;
  if (count === 0 || at < -1e-6 || at > count - 1 + 1e-6) return undefined;
  const low = Math.min(Math.max(0, Math.floor(at + 1e-6)), count - 1);
  const part = Math.max(0, at - low);
  const size = 3 * motion.markerCount;
  const first = motion.positions.subarray(low * size, (low + 1) * size);
  if (part < 1e-6 || low + 1 >= count) return first.slice();
  const second = motion.positions.subarray((low + 1) * size, (low + 2) * size);
  return first.map((value, i) => value + part * (second[i]! - value));
}

// Frames [from, to] (s) of a motion as a motion of its own; at least one frame.
export function cutMotion(motion: MarkerMotion, from: number, to: number): MarkerMotion {
  const count = frameCountOf(motion);
  const size = 3 * motion.markerCount;
  const first = Math.min(
    Math.max(0, Math.round(from * motion.frameRateHz)),
    Math.max(0, count - 1),
  );
  const last = Math.min(
    Math.max(first, Math.round(to * motion.frameRateHz)),
    Math.max(0, count - 1),
  );
  return { ...motion, positions: motion.positions.slice(first * size, (last + 1) * size) };
}

// Mean distance of markers that both poses have, m; undefined if they share none.
export function meanMarkerError(a: Float32Array, b: Float32Array): number | undefined {
  let sum = 0;
  let count = 0;
  for (let i = 0; i + 2 < Math.min(a.length, b.length); i += 3) {
    const distance = Math.hypot(a[i]! - b[i]!, a[i + 1]! - b[i + 1]!, a[i + 2]! - b[i + 2]!);
    if (Number.isNaN(distance)) continue;
    sum += distance;
    ++count;
  }
  return count > 0 ? sum / count : undefined;
}

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
