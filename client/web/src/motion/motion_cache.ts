import type { Api } from '../api/api';
import { bytesOf, type Motion } from './motion';
import { readMotion } from './motion_reader';

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
