import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { element } from '../dom/element';
import type { ThemeSwitch } from '../shell/theme';
import { rangeAfterKey } from './chart_keys';
import { zoomByTouch } from './chart_pinch';

export interface ChartLine {
  name: string;
  // Name of a colour of the style sheet, such as --left.
  color: string;
  values: ArrayLike<number | null>;
}

export interface ChartOptions {
  theme: ThemeSwitch;
  // What the chart shows, for screen readers.
  label: string;
  unit: string;
  // x are seconds since 1970, shown as times of day; otherwise plain numbers.
  times?: boolean;
  // Name or unit of x, if it is no time of day; default: s.
  x?: string;
  height?: number;
  // The user has clicked at x.
  pick?: (x: number) => void;
}

const kHeight = 180;

// Lines over a common x, with a vertical line at a moment. The keys +, - and 0 zoom.
export class LineChart {
  readonly node: HTMLElement;
  private chart: uPlot | undefined;
  private lines: readonly ChartLine[] = [];
  private unit: string;
  private x: ArrayLike<number> = [];
  private marked = NaN;
  private readonly mark = element('div', { class: 'chart-mark', hidden: true });
  private readonly observer: ResizeObserver;
  private readonly remove: () => void;

  constructor(private readonly options: ChartOptions) {
    this.unit = options.unit;
    this.node = element('div', {
      class: 'chart',
      role: 'img',
      'aria-label': options.label,
      tabindex: 0,
    });
    this.node.addEventListener('keydown', (event) => {
      this.press(event);
    });
    this.observer = new ResizeObserver(() => {
      const width = this.node.clientWidth;
      if (width > 0) this.chart?.setSize({ width, height: this.height });
      this.placeMark();
    });
    this.observer.observe(this.node);
    this.remove = options.theme.onChange(() => {
      this.build();
    });
  }

  // Shows lines; each has as many values as x. null and NaN are gaps.
  setData(x: ArrayLike<number>, lines: readonly ChartLine[], unit = this.options.unit): void {
    const same =
      unit === this.unit &&
      this.lines.length === lines.length &&
      this.lines.every((line, index) => line.name === lines[index]?.name);
    this.unit = unit;
    this.x = x;
    this.lines = lines;
    if (same && this.chart) this.chart.setData(this.data());
    else this.build();
  }

  // Marks a moment by a line; NaN: none.
  setMark(x: number): void {
    this.marked = x;
    this.placeMark();
  }

  dispose(): void {
    this.observer.disconnect();
    this.remove();
    this.chart?.destroy();
    this.chart = undefined;
    this.node.remove();
  }

  private get height(): number {
    return this.options.height ?? kHeight;
  }

  private data(): uPlot.AlignedData {
    const gaps = (values: ArrayLike<number | null>) =>
      Array.from(values, (value) => (value === null || Number.isNaN(value) ? null : value));
    return [Array.from(this.x), ...this.lines.map((line) => gaps(line.values))];
  }

  private build(): void {
    this.chart?.destroy();
    this.node.replaceChildren();
    if (this.lines.length === 0) return;
    const { theme } = this.options;
    const axis: uPlot.Axis = {
      stroke: theme.color('--text'),
      grid: { stroke: theme.color('--line'), width: 1 },
      ticks: { stroke: theme.color('--line'), width: 1 },
    };
    this.chart = new uPlot(
      {
        width: Math.max(100, this.node.clientWidth),
        height: this.height,
        scales: { x: { time: this.options.times === true } },
        // As all times of the page and of the log.
        tzDate: (seconds) => uPlot.tzDate(new Date(1000 * seconds), 'Etc/UTC'),
        axes: [axis, { ...axis, label: this.unit, size: 56, labelSize: 18, space: 24 }],
        series: [
          { label: this.options.times === true ? 'time' : (this.options.x ?? 's') },
          ...this.lines.map((line) => ({
            label: line.name,
            stroke: theme.color(line.color),
            width: 1.5,
            points: { show: false },
          })),
        ],
        cursor: { drag: { x: true, y: false } },
        hooks: {
          draw: [
            () => {
              this.placeMark();
            },
          ],
        },
      },
      this.data(),
      this.node,
    );
    this.chart.over.append(this.mark);
    zoomByTouch(this.chart);
    const { over } = this.chart;
    over.addEventListener('click', (event) => {
      if (this.chart) this.options.pick?.(this.chart.posToVal(event.offsetX, 'x'));
    });
  }

  private press(event: KeyboardEvent): void {
    const { min, max } = this.chart?.scales['x'] ?? {};
    if (min === undefined || max === undefined) return;
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const all = { min: this.x[0] ?? min, max: this.x[this.x.length - 1] ?? max };
    const range = rangeAfterKey(event.key, { min, max }, this.marked, all);
    if (!range) return;
    event.preventDefault();
    this.chart?.setScale('x', range);
  }

  private placeMark(): void {
    const at = this.positionOf(this.marked);
    this.mark.hidden = at === undefined;
    if (at !== undefined) this.mark.style.transform = `translateX(${at}px)`;
  }

  // Pixels from the left end of the plot; undefined outside it. Reads nothing from the document, so
  // that a mark that moves with a motion makes no layout.
  private positionOf(x: number): number | undefined {
    const scale = this.chart?.scales['x'];
    if (!this.chart || scale?.min === undefined || scale.max === undefined) return undefined;
    const part = (x - scale.min) / (scale.max - scale.min);
    const width = this.chart.bbox.width / devicePixelRatio;
    return part >= 0 && part <= 1 ? Math.round(part * width) : undefined;
  }
}
