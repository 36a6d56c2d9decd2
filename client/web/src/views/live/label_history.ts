import type { ObserveResponse } from '../../api/messages';

// What the ribbon shows of one answer.
export interface LabelMoment {
  // Seconds of the stream.
  time: number;
  // Most probable label; empty if the motion is unknown or there is no label yet.
  label: string;
  // Probability of the label, or of unknown motion.
  probability: number;
  unknown: boolean;
  // The stream was not watched between this moment and the next one.
  beforeGap?: boolean;
}

// The most probable label of an answer; unknown if that is more probable than each label.
export function momentOf(answer: ObserveResponse, frameRateHz: number): LabelMoment {
  const [best] = answer.labels;
  const unknown = answer.unknownProbability ?? 0;
  const time = Number(answer.frame) / Math.max(frameRateHz, 1e-9);
  if (best && best.probability >= unknown) {
    return { time, label: best.label, probability: best.probability, unknown: false };
  }
  return { time, label: '', probability: unknown, unknown: best !== undefined || unknown > 0 };
}

// The moments of the last seconds, oldest first.
export class LabelHistory {
  private readonly moments: LabelMoment[] = [];

  constructor(private readonly lengthSeconds: number) {}

  get all(): readonly LabelMoment[] {
    return this.moments;
  }

  // The stream is not watched from the last moment to the next one.
  interrupt(): void {
    const last = this.moments.at(-1);
    if (last) last.beforeGap = true;
  }

  // Adds a moment. A stream that begins again at an earlier time empties the history.
  add(moment: LabelMoment): void {
    const last = this.moments.at(-1);
    if (last && moment.time < last.time) this.moments.length = 0;
    this.moments.push(moment);
    const begin = moment.time - this.lengthSeconds;
    while (this.moments[1] && this.moments[1].time <= begin) this.moments.shift();
  }
}
