import type { ObserveResponse } from '../../api/messages';
import { element } from '../../dom/element';
import { legendEntries } from '../../drawing/labels';
import type { LabelPalette } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';

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

const kWidth = 1200;
const kHeight = 40;
// Length of a moment without a next one.
const kLastSeconds = 0.05;

// Labels over the last seconds, the newest at the right. The height is the probability; hatching is
// unknown motion.
export class LabelRibbon {
  readonly node: HTMLElement;
  private readonly canvas = element('canvas', { width: kWidth, height: kHeight });
  private readonly legend = element('div', { class: 'legend' });
  private readonly text = element('p', { class: 'ribbon-text', 'aria-live': 'off' });

  constructor(
    private readonly theme: ThemeSwitch,
    private readonly palette: LabelPalette,
    private readonly lengthSeconds: number,
  ) {
    this.node = element(
      'div',
      { class: 'ribbon' },
      element(
        'div',
        { role: 'img', 'aria-label': `Labels of the last ${lengthSeconds} seconds` },
        this.canvas,
      ),
      this.legend,
      this.text,
    );
  }

  draw(moments: readonly LabelMoment[]): void {
    const context = this.canvas.getContext('2d');
    const last = moments.at(-1);
    if (!context || !last) return;
    context.clearRect(0, 0, kWidth, kHeight);
    const scale = kWidth / this.lengthSeconds;
    const labels = moments.flatMap(({ label, unknown }) => (unknown ? [] : [label]));
    this.palette.add(labels);
    const styles = this.palette.styles(this.theme.name);
    this.legend.replaceChildren(...legendEntries(labels, styles));
    const unknown = moments.some((moment) => moment.unknown) ? this.hatching(context) : '';
    moments.forEach((moment, index) => {
      const following = moment.beforeGap === true ? undefined : moments[index + 1];
      const next = following?.time ?? moment.time + kLastSeconds;
      const x = kWidth - (last.time - moment.time) * scale;
      const height = kHeight * Math.min(Math.max(moment.probability, 0.04), 1);
      context.fillStyle = moment.unknown ? unknown : (styles.get(moment.label)?.color ?? 'gray');
      context.fillRect(x, kHeight - height, Math.max(1, (next - moment.time) * scale), height);
    });
    this.text.textContent = describe(last);
  }

  // Diagonal lines, as in the ribbon of a query.
  private hatching(context: CanvasRenderingContext2D): CanvasPattern | string {
    const size = 8;
    const tile = element('canvas', { width: size, height: size });
    const drawing = tile.getContext('2d');
    if (!drawing) return this.theme.color('--hint');
    drawing.fillStyle = this.theme.color('--panel');
    drawing.fillRect(0, 0, size, size);
    drawing.fillStyle = this.theme.color('--hint');
    for (let y = 0; y < size; ++y) {
      for (let width = 0; width < 3; ++width) drawing.fillRect((y + width) % size, y, 1, 1);
    }
    return context.createPattern(tile, 'repeat') ?? this.theme.color('--hint');
  }
}

function describe(moment: LabelMoment): string {
  const percent = `${Math.round(100 * moment.probability)} %`;
  if (moment.unknown) return `Unknown motion, ${percent}`;
  return moment.label === '' ? 'No label yet' : `${moment.label}, ${percent}`;
}
