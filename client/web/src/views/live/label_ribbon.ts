import { element } from '../../dom/element';
import { legendEntries } from '../../drawing/legend';
import type { LabelPalette } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';
import type { LabelMoment } from './label_history';

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
