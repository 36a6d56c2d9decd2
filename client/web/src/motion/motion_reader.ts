import type { Api } from '../api/api';
import { copyFrames, copyRotations, createMotion, type Motion, bytesOf } from './motion';

// Reads the motion of a clip. `onStart` gets it with the first block, `onBlock` follows each block.
// Rejects if the stream ends before the last frame.
export async function readMotion(
  api: Api,
  name: string,
  signal: AbortSignal,
  onStart: (motion: Motion) => void,
  onBlock: (motion: Motion) => void,
): Promise<Motion> {
  let motion: Motion | undefined;
  for await (const block of api.views.readClipMotion({ name, joints: true }, { signal })) {
    if (!motion) {
      if (!block.figure)
        throw new Error('Expected the figure in the first message of the motion, got none.');
      motion = createMotion(
        name,
        block.figure,
        block.frameRateHz,
        block.clipFrameCount,
        block.contacts.length > 0,
        block.jointPositions.length > 0,
      );
      onStart(motion);
    }
    copyFrames(motion.markers, block.firstFrame, block.markerPositions);
    copyFrames(motion.joints, block.firstFrame, block.jointPositions);
    copyRotations(motion.joints, block.firstFrame, block.jointRotations);
    if (block.firstFrame + block.contacts.length <= motion.contacts.length) {
      motion.contacts.set(block.contacts, block.firstFrame);
    }
    motion.receivedFrames = Math.max(motion.receivedFrames, block.firstFrame + block.frameCount);
    onBlock(motion);
  }
  return completeMotion(motion);
}

// Returns a motion whose stream has ended. Throws if it lacks frames, for example because a shorter
// clip has replaced it.
export function completeMotion(motion: Motion | undefined): Motion {
  if (!motion || motion.receivedFrames < motion.frameCount) {
    throw new Error(
      `Expected ${motion?.frameCount ?? 'some'} frames, got ${motion?.receivedFrames ?? 0}.`,
    );
  }
  return motion;
}

// Reads frames spread over a clip, in one message, for a thumbnail.
export async function readPoses(
  api: Api,
  name: string,
  frameCount: number,
  poseCount: number,
  signal: AbortSignal,
): Promise<Motion | undefined> {
  const stride = Math.max(1, Math.floor(frameCount / poseCount));
  let motion: Motion | undefined;
  const firstFrame = Math.floor(stride / 2);
  for await (const block of api.views.readClipMotion({ name, firstFrame, stride }, { signal })) {
    if (!motion) {
      if (!block.figure) return undefined;
      motion = createMotion(name, block.figure, block.frameRateHz, block.frameCount, false, false);
    }
    const index = Math.round((block.firstFrame - firstFrame) / stride);
    copyFrames(motion.markers, index, block.markerPositions);
    motion.receivedFrames = index + block.frameCount;
  }
  return motion;
}

// Motion of the clips used last. Complete motions stay until their sum exceeds the limit; the one
// used longest ago goes first.
export class MotionCache {
  private readonly motions = new Map<string, Motion>();
  private total = 0;

  constructor(
    private readonly api: Api,
    private readonly limitBytes: number,
  ) {}

  get byteCount(): number {
    return this.total;
  }

  // Loads a motion. `onStart` gets it as soon as its first block is there; `onBlock` follows each
  // block. `etag` is that of the clip: a changed clip is loaded again.
  async load(
    name: string,
    etag: string,
    signal: AbortSignal,
    onStart: (motion: Motion) => void,
    onBlock: (motion: Motion) => void = () => undefined,
  ): Promise<Motion> {
    const key = `${name} ${etag}`;
    const stored = this.motions.get(key);
    if (stored) {
      this.motions.delete(key);
      this.motions.set(key, stored);
      onStart(stored);
      onBlock(stored);
      return stored;
    }
    const motion = await readMotion(this.api, name, signal, onStart, onBlock);
    this.add(key, motion);
    return motion;
  }

  private add(key: string, motion: Motion): void {
    const previous = this.motions.get(key);
    if (previous) this.total -= bytesOf(previous);
    this.motions.delete(key);
    this.motions.set(key, motion);
    this.total += bytesOf(motion);
    for (const [oldKey, old] of this.motions) {
      if (this.total <= this.limitBytes || oldKey === key) break;
      this.motions.delete(oldKey);
      this.total -= bytesOf(old);
    }
  }
}
