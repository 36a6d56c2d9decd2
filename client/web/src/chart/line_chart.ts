import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { arrowOf } from '../dom/arrow_keys';
import { element } from '../dom/element';
import type { ThemeSwitch } from '../shell/theme';
import {
  zoomByKeys,
  zoomByTouch,
  rangeInside,
  type ChartRange,
  type ZoomTarget,
} from './chart_zoom';

export interface ChartLine {
  name: string;
  // A colour, or the name of one of the style sheet, such as --left.
  color: string;
  dash?: readonly number[];
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
  // Label of the axis of x; default: none.
  xLabel?: string;
  // Default: true.
  legend?: boolean;
  height?: number;
  // The user has clicked at x.
  pick?: (x: number) => void;
  // The line that is nearest to the pointer, or chosen by the keys up and down, and the index of the
  // value at the pointer. The chart draws the others faintly.
  near?: (line: number | undefined, index: number | undefined) => void;
}

const kHeight = 180;

// The least pixels between two numbers of an axis of `pixels`. One number would not show the scale;
// uPlot takes at most twice this space.
const spaceOfNumbers: uPlot.Axis.Space = (_chart, _axis, _min, _max, pixels) =>
  Math.min(24, pixels / 4);

// Lines over a common x, with a vertical line at a moment. The keys +, - and 0, dragging and two
// fingers zoom; other values keep the zoom.
export class LineChart {
  readonly node: HTMLElement;
  private chart: uPlot | undefined;
  private lines: readonly ChartLine[] = [];
  private unit: string;
  private x: ArrayLike<number> = [];
  private marked = NaN;
  // Undefined: all is shown.
  private zoom: ChartRange | undefined;
  private chosen = -1;
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
    zoomByKeys(this.node, this.zoomTarget, () => this.marked);
    if (options.near)
      this.node.addEventListener('keydown', (event) => {
        this.chooseLine(event);
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
      this.lines.every((line, index) => isSameLine(line, lines[index]));
    this.unit = unit;
    this.x = x;
    this.lines = lines;
    if (!same || !this.chart) {
      this.build();
      return;
    }
    const { all } = this;
    if (!this.zoom || !all) {
      this.chart.setData(this.data());
      return;
    }
    const { min, max } = this.zoom;
    this.chart.setData(this.data(), false);
    this.chart.setScale('x', rangeInside(min, max - min, all));
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
    this.lines = [];
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
    this.chart = undefined;
    this.chosen = -1;
    this.node.replaceChildren();
    if (this.lines.length === 0) return;
    const { theme, near } = this.options;
    const { zoom, all } = this;
    const axis: uPlot.Axis = {
      stroke: theme.color('--text'),
      grid: { stroke: theme.color('--line'), width: 1 },
      ticks: { stroke: theme.color('--line'), width: 1 },
    };
    const { xLabel } = this.options;
    const xAxis = xLabel === undefined ? axis : { ...axis, label: xLabel, labelSize: 18 };
    this.chart = new uPlot(
      {
        width: Math.max(100, this.node.clientWidth),
        height: this.height,
        scales: { x: { time: this.options.times === true } },
        // As all times of the page and of the log.
        tzDate: (seconds) => uPlot.tzDate(new Date(1000 * seconds), 'Etc/UTC'),
        legend: { show: this.options.legend !== false },
        axes: [
          xAxis,
          { ...axis, label: this.unit, size: 56, labelSize: 18, space: spaceOfNumbers },
        ],
        series: [
          { label: this.options.times === true ? 'time' : (this.options.x ?? 's') },
          ...this.lines.map((line) => ({
            label: line.name,
            stroke: line.color.startsWith('--') ? theme.color(line.color) : line.color,
            dash: [...(line.dash ?? [])],
            width: 1.5,
            // A line of one value has no length.
            points: { show: (chart: uPlot) => chart.data[0].length === 1 },
          })),
        ],
        cursor: {
          drag: { x: true, y: false },
          ...(near ? { focus: { prox: Number.MAX_VALUE } } : {}),
        },
        hooks: {
          draw: [
            () => {
              this.placeMark();
            },
          ],
          setScale: [
            (chart, scale) => {
              if (chart === this.chart && scale === 'x') this.noteZoom();
            },
          ],
          setSeries: [
            (chart, series) => {
              if (chart !== this.chart || !near) return;
              this.chosen = (series ?? 0) - 1;
              near(this.chosen < 0 ? undefined : this.chosen, chart.cursor.idx ?? undefined);
            },
          ],
        },
      },
      this.data(),
      this.node,
    );
    if (zoom && all) this.chart.setScale('x', rangeInside(zoom.min, zoom.max - zoom.min, all));
    const { over } = this.chart;
    over.append(this.mark);
    zoomByTouch(over, this.zoomTarget);
    over.addEventListener('click', (event) => {
      if (this.chart) this.options.pick?.(this.chart.posToVal(event.offsetX, 'x'));
    });
  }

  // Undefined without values.
  private get all(): ChartRange | undefined {
    const [min, max] = [this.x[0], this.x[this.x.length - 1]];
    return min === undefined || max === undefined ? undefined : { min, max };
  }

  private readonly zoomTarget: ZoomTarget = {
    ranges: () => {
      const { min, max } = this.chart?.scales['x'] ?? {};
      const { all } = this;
      return min === undefined || max === undefined || !all
        ? undefined
        : { shown: { min, max }, all };
    },
    show: (range) => {
      this.chart?.setScale('x', range);
    },
  };

  private noteZoom(): void {
    const { shown, all } = this.zoomTarget.ranges() ?? {};
    const zoomed = shown && all && (shown.min > all.min || shown.max < all.max);
    this.zoom = zoomed ? shown : undefined;
  }

  private chooseLine(event: KeyboardEvent): void {
    const step = arrowOf(event.key)?.up ?? 0;
    if (step === 0 || this.lines.length === 0) return;
    event.preventDefault();
    // Up from no line is the first one, down the last one.
    const from = this.chosen < 0 && step < 0 ? 0 : this.chosen;
    const line = (from + step + this.lines.length) % this.lines.length;
    this.chart?.setSeries(line + 1, { focus: true });
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

function isSameLine(a: ChartLine, b: ChartLine | undefined): boolean {
  const dashOf = ({ dash = [] }: ChartLine) => dash.join();
  return b !== undefined && a.name === b.name && a.color === b.color && dashOf(a) === dashOf(b);
}
