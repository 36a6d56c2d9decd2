import { element, replaceChildren, svgElement } from '../../dom/element';
import { percent } from '../../dom/format';
import { labelName, legendEntries } from '../../drawing/legend';
import type { LabelStyle } from '../../drawing/palette';
import { ribbonAreas, runsOf, windowAt, winnerOf, type LabelledWindow } from './ribbon_layout';

const kWidth = 1000;
const kHeight = 90;

// The probabilities of labels and of unknown motion over time, below a playing motion. A click
// moves the motion; for keys there is the slider of the player.
export class RecognitionRibbon {
  readonly node = element('section', { class: 'ribbon', 'aria-label': 'Recognition' });
  private readonly picture = svgElement('svg', {
    viewBox: `0 0 ${kWidth} ${kHeight}`,
    preserveAspectRatio: 'none',
    'aria-hidden': 'true',
  });
  private readonly areas = svgElement('g');
  private readonly head = svgElement('line', { class: 'playhead', y1: 0, y2: kHeight });
  private readonly now = element('p', { class: 'ribbon-now' });
  private readonly runs = element('ol', { class: 'ribbon-runs' });
  private readonly legend = element('div', { class: 'legend' });
  private windows: readonly LabelledWindow[] = [];
  private duration = 1;
  private shownWindow = -2;

  constructor(seek: (seconds: number) => void) {
    this.picture.append(unknownPattern(), this.areas, this.head);
    this.picture.addEventListener('click', (event) => {
      const box = this.picture.getBoundingClientRect();
      seek(((event.clientX - box.left) / Math.max(1, box.width)) * this.duration);
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
    this.duration = Math.max(duration, 1e-6);
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

  // Moves the line of the present time.
  mark(seconds: number): void {
    const x = String((seconds / this.duration) * kWidth);
    this.head.setAttribute('x1', x);
    this.head.setAttribute('x2', x);
    const at = windowAt(this.windows, seconds);
    if (at === this.shownWindow) return;
    this.shownWindow = at;
    const window = this.windows[at];
    this.now.textContent = window ? describeWindow(window) : '';
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

function unknownPattern(): SVGDefsElement {
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
  return svgElement('defs', {}, pattern);
}
