const kWindow = 240;

// Work of the main thread for the last pictures.
export class FrameStatistics {
  private readonly work: number[] = [];
  private readonly intervals: number[] = [];
  drawCalls = 0;
  pictures = 0;

  // Adds a picture: milliseconds of work, seconds since the picture before (0: none), draw calls.
  add(milliseconds: number, seconds: number, drawCalls: number): void {
    ++this.pictures;
    push(this.work, milliseconds);
    if (seconds > 0) push(this.intervals, seconds);
    this.drawCalls = drawCalls;
  }

  // 95th percentile of the work, in milliseconds; 0 without pictures.
  get p95Milliseconds(): number {
    return percentile(this.work, 0.95);
  }

  // Pictures per second; 0 without an animation.
  get rateHz(): number {
    const total = this.intervals.reduce((sum, interval) => sum + interval, 0);
    return total > 0 ? this.intervals.length / total : 0;
  }
}

export function percentile(values: readonly number[], fraction: number): number {
  if (values.length === 0) return 0;
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))] ?? 0;
}

function push(values: number[], value: number): void {
  values.push(value);
  if (values.length > kWindow) values.shift();
}
