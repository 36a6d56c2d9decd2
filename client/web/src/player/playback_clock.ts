import { snapToFrame } from '../motion/motion';
import type { Scene } from '../scene/scene';

export interface PlaybackRange {
  begin: number;
  end: number;
}

// Time in a motion while it plays: speed, loop, range and steps of frames.
export class PlaybackClock {
  // Seconds from the start of the clip. While it plays, also inside the last frame.
  private seconds = 0;
  private running = false;
  private readonly listeners = new Set<(clock: PlaybackClock) => void>();
  private loopRange: PlaybackRange | null = null;
  speed = 1;
  loop = true;

  constructor(
    private lengthSeconds: number,
    private frameRateHz: number,
  ) {}

  // Seconds from the start of the clip, at most the start of the last frame.
  get time(): number {
    return Math.min(this.seconds, this.lastFrameSeconds);
  }

  get duration(): number {
    return this.lengthSeconds;
  }

  get playing(): boolean {
    return this.running;
  }

  get frameRate(): number {
    return this.frameRateHz;
  }

  // The frame at the present time.
  get frame(): number {
    const last = Math.max(0, Math.round(this.lengthSeconds * this.frameRateHz) - 1);
    return Math.min(last, Math.floor(this.seconds * this.frameRateHz + 1e-6));
  }

  // The part that is repeated; null: all.
  get range(): PlaybackRange | null {
    return this.loopRange;
  }

  set range(range: PlaybackRange | null) {
    this.loopRange = range && range.end > range.begin ? range : null;
    this.tell();
  }

  // The length of another motion, and the time to begin with: that of the nearest frame, because an
  // address has rounded times.
  resize(lengthSeconds: number, frameRateHz: number, time: number): void {
    this.lengthSeconds = lengthSeconds;
    this.frameRateHz = frameRateHz;
    this.seek(snapToFrame(time, frameRateHz));
  }

  // Calls back after each change. Returns the function that removes the listener.
  onChange(listener: (clock: PlaybackClock) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  seek(seconds: number): void {
    const inside = Math.max(0, Number.isFinite(seconds) ? seconds : 0);
    this.seconds = Math.min(inside, this.lastFrameSeconds);
    this.tell();
  }

  // Moves by frames, to the start of a frame, and stops.
  step(frames: number): void {
    this.running = false;
    this.seek((this.frame + frames) / this.frameRateHz);
  }

  play(): void {
    if (this.running || this.lengthSeconds <= 0) return;
    const end = this.loopRange?.end ?? this.lengthSeconds;
    if (this.seconds >= end - 1.5 / this.frameRateHz) this.seconds = this.loopRange?.begin ?? 0;
    this.running = true;
    this.tell();
  }

  pause(): void {
    if (!this.running) return;
    this.running = false;
    this.tell();
  }

  toggle(): void {
    if (this.running) this.pause();
    else this.play();
  }

  // Moves by the time that has passed. At the end it begins again or stops. The last frame is shown
  // as long as each other: a step can be shorter than a frame, so `seek` would hold it there.
  advance(elapsedSeconds: number): void {
    if (!this.running) return;
    const begin = this.loopRange?.begin ?? 0;
    const end = Math.min(this.loopRange?.end ?? this.lengthSeconds, this.lengthSeconds);
    const next = this.seconds + elapsedSeconds * this.speed;
    if (next < end) {
      this.seconds = Math.max(0, next);
      this.tell();
    } else if (this.loop) {
      this.seek(begin + ((next - begin) % Math.max(end - begin, 1 / this.frameRateHz)));
    } else {
      this.running = false;
      this.seek(Math.max(begin, end - 1 / this.frameRateHz));
    }
  }

  private get lastFrameSeconds(): number {
    return Math.max(0, this.lengthSeconds - 1 / this.frameRateHz);
  }

  private tell(): void {
    for (const listener of [...this.listeners]) listener(this);
  }
}

const kLongestStepSeconds = 0.25;

// Moves a clock with the pictures of the screen while it plays: with those of a scene, so that both
// are in the same picture, or without WebGL by itself. Returns the function that ends it.
export function driveClock(clock: PlaybackClock, scene: Scene | undefined): () => void {
  let stop: (() => void) | undefined;
  const advance = (seconds: number) => {
    clock.advance(Math.min(seconds, kLongestStepSeconds));
  };
  const remove = clock.onChange(() => {
    if (clock.playing && !stop) {
      stop = scene ? scene.animate(advance) : animateWithoutScene(advance);
    } else if (!clock.playing && stop) {
      stop();
      stop = undefined;
    }
  });
  return () => {
    remove();
    stop?.();
  };
}

function animateWithoutScene(advance: (seconds: number) => void): () => void {
  let last = 0;
  let request = 0;
  const tick = (time: number) => {
    request = requestAnimationFrame(tick);
    if (last > 0) advance((time - last) / 1000);
    last = time;
  };
  request = requestAnimationFrame(tick);
  return () => {
    cancelAnimationFrame(request);
  };
}
