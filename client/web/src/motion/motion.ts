import type { Bone, Figure, LinkVisual } from '../api/messages';

// Points that move: markers or joints.
export interface PointTrack {
  readonly names: readonly string[];
  readonly bones: readonly Bone[];
  // frames x points x 3, m, z up; NaN: missing or not received yet.
  readonly positions: Float32Array;
}

// Joints that move, with the visual shapes of a robot's links.
export interface JointTrack extends PointTrack {
  readonly visuals: readonly LinkVisual[];
  // frames x joints x 4, from the frame of the joint to the world, unit quaternions x, y, z, w; empty
  // without visuals. NaN: not received yet.
  readonly rotations: Float32Array;
}

// Motion of a clip. Blocks arrive in order; `receivedFrames` grows until it is `frameCount`.
export interface Motion {
  readonly name: string;
  readonly frameRateHz: number;
  readonly frameCount: number;
  readonly markers: PointTrack;
  // Joints of the recorded skeleton; without names if there are none.
  readonly joints: JointTrack;
  // One byte a frame: bit 0 left foot, bit 1 right foot; empty if the marker set has no feet.
  readonly contacts: Uint8Array;
  receivedFrames: number;
}

// A motion of NaN, to be filled by `addBlock`.
export function createMotion(
  name: string,
  figure: Figure,
  frameRateHz: number,
  frameCount: number,
  hasContacts: boolean,
  hasJoints: boolean,
): Motion {
  return {
    name,
    frameRateHz,
    frameCount,
    receivedFrames: 0,
    markers: createTrack(figure.markerNames, figure.markerBones, frameCount),
    joints: createJoints(hasJoints ? figure : undefined, frameCount),
    contacts: new Uint8Array(hasContacts ? frameCount : 0),
  };
}

// Copies little-endian float32 into `target` at a frame. Bytes beyond the end are ignored.
export function copyFrames(target: PointTrack, firstFrame: number, bytes: Uint8Array): void {
  copyFloats(target.positions, firstFrame * target.names.length * 3, bytes);
}

// The same for the rotations of joints.
export function copyRotations(target: JointTrack, firstFrame: number, bytes: Uint8Array): void {
  copyFloats(target.rotations, firstFrame * target.names.length * 4, bytes);
}

// Bytes as float32; the bytes of a message can begin at any address, so they are copied.
export function floatsOf(bytes: Uint8Array): Float32Array {
  const count = Math.floor(bytes.length / 4);
  const floats = new Float32Array(count);
  new Uint8Array(floats.buffer).set(bytes.subarray(0, count * 4));
  return floats;
}

// The frame that is shown at a time: the last one that has begun.
export function frameAt(motion: Motion, seconds: number): number {
  const frame = Math.floor(seconds * motion.frameRateHz + 1e-6);
  return Math.min(Math.max(frame, 0), Math.max(0, motion.frameCount - 1));
}

export function durationOf(motion: Motion): number {
  return motion.frameCount / motion.frameRateHz;
}

export function bytesOf(motion: Motion): number {
  return (
    motion.markers.positions.byteLength +
    motion.joints.positions.byteLength +
    motion.joints.rotations.byteLength +
    motion.contacts.byteLength
  );
}

// The positions of one frame, as a view of the track.
export function frameOf(track: PointTrack, frame: number): Float32Array {
  const size = track.names.length * 3;
  return track.positions.subarray(frame * size, (frame + 1) * size);
}

// The rotations of one frame, as a view of the track.
export function rotationsOf(track: JointTrack, frame: number): Float32Array {
  const size = track.names.length * 4;
  return track.rotations.subarray(frame * size, (frame + 1) * size);
}

function copyFloats(target: Float32Array, first: number, bytes: Uint8Array): void {
  const all = new Uint8Array(target.buffer, target.byteOffset, target.byteLength);
  const offset = 4 * first;
  if (offset < 0 || offset > all.length) return;
  all.set(bytes.subarray(0, all.length - offset), offset);
}

function createJoints(figure: Figure | undefined, frameCount: number): JointTrack {
  const { jointNames = [], jointBones = [], jointVisuals = [] } = figure ?? {};
  const count = jointVisuals.length > 0 ? frameCount * jointNames.length * 4 : 0;
  return {
    ...createTrack(jointNames, jointBones, frameCount),
    visuals: jointVisuals,
    rotations: new Float32Array(count).fill(NaN),
  };
}

function createTrack(
  names: readonly string[],
  bones: readonly Bone[],
  frameCount: number,
): PointTrack {
  return { names, bones, positions: new Float32Array(frameCount * names.length * 3).fill(NaN) };
}

// The time of the nearest frame, s.
export function snapToFrame(seconds: number, frameRateHz: number): number {
  return Math.round(seconds * frameRateHz) / frameRateHz;
}

// The bytes of float32 values, little-endian, for a `bytes` field.
export function floatBytes(floats: Float32Array): Uint8Array {
  const bytes = new Uint8Array(4 * floats.length);
  const view = new DataView(bytes.buffer);
  floats.forEach((value, i) => {
    view.setFloat32(4 * i, value, true);
  });
  return bytes;
}
