import type { Api } from '../../api/api';
import type { Clip } from '../../api/messages';
import { element } from '../../dom/element';
import { frameOf, type Motion } from '../../motion/motion';
import { readPoses } from '../../motion/motion_reader';
import type { ThemeSwitch } from '../../shell/theme';

const kWidth = 120;
const kHeight = 64;
const kPoses = 5;
const kConcurrent = 3;
const kMaxStored = 1000;

interface Waiting {
  clip: Clip;
  canvas: HTMLCanvasElement;
}

// Small pictures of clips: some poses side by side, from the side, drawn when they scroll into view.
export class Thumbnails {
  private readonly observer: IntersectionObserver;
  private readonly waiting = new Map<Element, Waiting>();
  private readonly queue: Waiting[] = [];
  private readonly stored = new Map<string, Motion>();
  // The pictures of the present page.
  private readonly drawn = new Map<HTMLCanvasElement, Motion>();
  private running = 0;

  constructor(
    private readonly api: Api,
    private readonly theme: ThemeSwitch,
    private readonly signal: AbortSignal,
  ) {
    this.observer = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        const item = this.waiting.get(entry.target);
        if (!entry.isIntersecting || !item) continue;
        this.forget(entry.target);
        this.queue.push(item);
      }
      this.next();
    });
    const removeTheme = theme.onChange(() => {
      for (const [canvas, motion] of this.drawn) this.paint(canvas, motion);
    });
    signal.addEventListener('abort', () => {
      this.observer.disconnect();
      removeTheme();
    });
  }

  // A picture of a clip; empty until its poses are there.
  create(clip: Clip): HTMLCanvasElement {
    const canvas = element('canvas', { class: 'thumbnail', 'aria-hidden': 'true' });
    canvas.width = kWidth * Math.ceil(devicePixelRatio);
    canvas.height = kHeight * Math.ceil(devicePixelRatio);
    this.waiting.set(canvas, { clip, canvas });
    this.observer.observe(canvas);
    return canvas;
  }

  // Forgets the pictures of the page before.
  clear(): void {
    for (const canvas of [...this.waiting.keys()]) this.forget(canvas);
    this.queue.length = 0;
    this.drawn.clear();
  }

  private forget(canvas: Element): void {
    this.waiting.delete(canvas);
    this.observer.unobserve(canvas);
  }

  private next(): void {
    while (this.running < kConcurrent && !this.signal.aborted) {
      const item = this.queue.shift();
      if (!item) return;
      ++this.running;
      void this.draw(item).finally(() => {
        --this.running;
        this.next();
      });
    }
  }

  private async draw({ clip, canvas }: Waiting): Promise<void> {
    // A clip that is replaced or derived again has another etag.
    const key = `${clip.name} ${clip.etag}`;
    try {
      const motion =
        this.stored.get(key) ??
        (await readPoses(this.api, clip.name, clip.frameCount, kPoses, this.signal));
      if (!motion) return;
      this.stored.delete(key);
      this.stored.set(key, motion);
      const [oldest] = this.stored.keys();
      if (this.stored.size > kMaxStored && oldest !== undefined) this.stored.delete(oldest);
      this.paint(canvas, motion);
    } catch {
      // A clip that was deleted meanwhile has no picture; the list shows other errors.
    }
  }

  private paint(canvas: HTMLCanvasElement, motion: Motion): void {
    if (!canvas.isConnected) return;
    this.drawn.set(canvas, motion);
    drawPoses(canvas, motion, this.theme.color('--middle'));
  }
}

// Draws the poses of a motion beside each other, seen across the direction of its longest extent.
export function drawPoses(canvas: HTMLCanvasElement, motion: Motion, color: string): void {
  const context = canvas.getContext('2d');
  const lines = poseLines(motion, canvas.width, canvas.height);
  if (!context) return;
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.strokeStyle = color;
  context.lineWidth = Math.max(1, canvas.height / 64);
  context.lineCap = 'round';
  context.beginPath();
  for (const [x0, y0, x1, y1] of lines) {
    context.moveTo(x0, y0);
    context.lineTo(x1, y1);
  }
  context.stroke();
}

type Line = [number, number, number, number];

// Bones of all poses as lines on a picture of width x height pixels; each pose in its own column.
export function poseLines(motion: Motion, width: number, height: number): Line[] {
  const frames = Math.min(motion.frameCount, kPoses);
  const poses = Array.from({ length: frames }, (_, frame) => frameOf(motion.markers, frame));
  const top = Math.max(0.5, ...poses.map((pose) => maxOf(pose, 2)));
  const scale = (0.92 * height) / top;
  const lines: Line[] = [];
  poses.forEach((pose, frame) => {
    const center = ((frame + 0.5) * width) / frames;
    // Across: x minus y shows walks along both axes.
    const across = (point: number) =>
      (pose[3 * point] ?? NaN) * 0.8 - (pose[3 * point + 1] ?? NaN) * 0.6;
    const points = motion.markers.names
      .map((_, point) => across(point))
      .filter((value) => !Number.isNaN(value));
    const middle = points.reduce((sum, value) => sum + value, 0) / Math.max(1, points.length);
    for (const bone of motion.markers.bones) {
      const line: Line = [
        center + (across(bone.fromPoint) - middle) * scale,
        0.97 * height - (pose[3 * bone.fromPoint + 2] ?? NaN) * scale,
        center + (across(bone.toPoint) - middle) * scale,
        0.97 * height - (pose[3 * bone.toPoint + 2] ?? NaN) * scale,
      ];
      if (line.every(Number.isFinite)) lines.push(line);
    }
  });
  return lines;
}

function maxOf(pose: Float32Array, axis: number): number {
  let top = -Infinity;
  for (let index = axis; index < pose.length; index += 3) {
    const value = pose[index] ?? NaN;
    if (value > top) top = value;
  }
  return top;
}
