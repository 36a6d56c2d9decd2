import {
  zoomByKeys,
  zoomByTouch,
  rangeInside,
  type ChartRange,
  type ZoomTarget,
  zoomByWheel,
} from '../../chart/chart_zoom';
import { element, replaceChildren, svgElement } from '../../dom/element';
import { percent } from '../../dom/format';
import { labelName, legendEntries } from '../../drawing/labels';
import type { LabelStyle } from '../../drawing/palette';
import { ribbonAreas, runsOf, windowAt, winnerOf, type LabelledWindow } from './ribbon_layout';

const kWidth = 1000;
const kHeight = 90;

// The probabilities of labels and of unknown motion over time, below a playing motion. A click
// moves the motion; for keys there is the slider of the player. The wheel, two fingers and the keys
// +, - and 0 zoom.
export class RecognitionRibbon {
  readonly node = element('section', { class: 'ribbon', 'aria-label': 'Recognition' });
  private readonly picture = svgElement('svg', {
    viewBox: `0 0 ${kWidth} ${kHeight}`,
    preserveAspectRatio: 'none',
    role: 'img',
    'aria-label': 'Probabilities of labels over time. The keys plus and minus zoom, 0 shows all.',
    tabindex: 0,
  });
  private readonly hatching = unknownPattern();
  private readonly areas = svgElement('g');
  private readonly head = svgElement('line', { class: 'playhead', y1: 0, y2: kHeight });
  private readonly now = element('p', { class: 'ribbon-now' });
  private readonly runs = element('ol', { class: 'ribbon-runs' });
  private readonly legend = element('div', { class: 'legend' });
  private windows: readonly LabelledWindow[] = [];
  private duration = 1;
  private marked = 0;
  // The part that is shown, s.
  private range: ChartRange = { min: 0, max: 1 };
  private shownWindow = -2;

  constructor(seek: (seconds: number) => void) {
    const { picture } = this;
    picture.append(svgElement('defs', {}, this.hatching), this.areas, this.head);
    picture.addEventListener('click', (event) => {
      const box = picture.getBoundingClientRect();
      const { min, max } = this.range;
      seek(min + ((event.clientX - box.left) / Math.max(1, box.width)) * (max - min));
    });
    const target: ZoomTarget = {
      ranges: () => ({ shown: this.range, all: this.all }),
      show: (range) => {
        this.setRange(range);
      },
    };
    zoomByKeys(picture, target, () => this.marked);
    zoomByTouch(picture, target);
    zoomByWheel(picture, target);
    picture.addEventListener('dblclick', () => {
      this.setRange(this.all);
    });
    const list = element(
      'details',
      {},
      element('summary', {}, 'Recognized parts as a list'),
      this.runs,
    );
    this.node.append(this.picture, this.now, this.legend, list);
  }

  show(
    windows: readonly LabelledWindow[],
    duration: number,
    styles: ReadonlyMap<string, LabelStyle>,
  ): void {
    this.windows = windows;
    const length = Math.max(duration, 1e-6);
    // The same motion in other colours keeps the zoom.
    if (length !== this.duration || windows.length === 0) this.range = { min: 0, max: length };
    this.duration = length;
    this.setRange(this.range);
    this.shownWindow = -2;
    const labels = labelsOf(windows);
    const shapes = ribbonAreas(windows, labels).map((area) => {
      const rect = svgElement('rect', {
        x: (area.startSeconds / this.duration) * kWidth,
        width: ((area.endSeconds - area.startSeconds) / this.duration) * kWidth,
        y: (1 - area.top) * kHeight,
        height: (area.top - area.bottom) * kHeight,
        class: area.unknown ? 'unknown' : null,
        fill: area.unknown ? 'url(#unknown-motion)' : null,
      });
      if (!area.unknown) rect.style.fill = styles.get(area.label)?.color ?? 'gray';
      return rect;
    });
    this.areas.replaceChildren(...shapes);
    this.drawLegend(windows, legendEntries(labels, styles));
    replaceChildren(
      this.runs,
      ...runsOf(windows).map((run) =>
        element(
          'li',
          {},
          `${run.startSeconds.toFixed(2)} s to ${run.endSeconds.toFixed(2)} s: ` +
            `${run.unknown ? 'unknown motion' : labelName(run.label)} (${percent(run.probability)})`,
        ),
      ),
    );
  }

  // Moves the line of the present time, and the part that is shown so that the line is in it.
  mark(seconds: number): void {
    const { min, max } = this.range;
    const isOutside = seconds < min || seconds > max;
    if (isOutside && seconds !== this.marked)
      this.setRange(rangeInside(seconds, max - min, this.all));
    this.marked = seconds;
    const x = String((seconds / this.duration) * kWidth);
    this.head.setAttribute('x1', x);
    this.head.setAttribute('x2', x);
    const at = windowAt(this.windows, seconds);
    if (at === this.shownWindow) return;
    this.shownWindow = at;
    const window = this.windows[at];
    this.now.textContent = window ? describeWindow(window) : '';
  }

  private get all(): ChartRange {
    return { min: 0, max: this.duration };
  }

  private setRange(range: ChartRange): void {
    this.range = range;
    const part = (range.max - range.min) / this.duration;
    const left = (range.min / this.duration) * kWidth;
    this.picture.setAttribute('viewBox', `${left} 0 ${part * kWidth} ${kHeight}`);
    // The lines of the hatching stay as thick and as steep as without zoom.
    this.hatching.setAttribute('patternTransform', `scale(${part} 1) rotate(45)`);
  }

  private drawLegend(windows: readonly LabelledWindow[], entries: readonly HTMLElement[]): void {
    const unknown = windows.some((window) => window.unknownProbability !== undefined)
      ? element(
          'span',
          { class: 'legend-clip' },
          element('span', { class: 'swatch unknown-swatch', 'aria-hidden': 'true' }),
          'unknown motion',
        )
      : null;
    replaceChildren(this.legend, ...entries, unknown);
  }
}

// Labels that are the most probable ones of a window, or above 5 % in one, in order of name.
export function labelsOf(windows: readonly LabelledWindow[]): string[] {
  const labels = new Set<string>();
  for (const window of windows) {
    const winner = winnerOf(window);
    if (winner && !winner.unknown) labels.add(winner.label);
    for (const { label, probability } of window.labels) if (probability > 0.05) labels.add(label);
  }
  return [...labels].sort();
}

// The first labels of a window as text.
export function describeWindow(window: LabelledWindow): string {
  const parts = window.labels
    .slice(0, 3)
    .map(({ label, probability }) => `${labelName(label)} ${percent(probability)}`);
  if (window.unknownProbability !== undefined) {
    parts.push(`unknown motion ${percent(window.unknownProbability)}`);
  }
  return `${parts.join(', ')}; familiarity ${percent(window.familiarity)}`;
}

function unknownPattern(): SVGPatternElement {
  const pattern = svgElement('pattern', {
    id: 'unknown-motion',
    width: 8,
    height: 8,
    patternUnits: 'userSpaceOnUse',
    patternTransform: 'rotate(45)',
  });
  pattern.append(
    svgElement('rect', { class: 'unknown-ground', width: 8, height: 8 }),
    svgElement('rect', { class: 'unknown-line', width: 2.5, height: 8 }),
  );
  return pattern;
}
