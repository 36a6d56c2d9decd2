import { LineChart } from '../../chart/line_chart';
import { element, labelled, replaceChildren, selectOf } from '../../dom/element';
import { curvesOf, frameTimes, valueText, type Curve, type CurveKind } from '../../motion/curves';
import { frameAt, type Motion, type PointTrack } from '../../motion/motion';
import type { ThemeSwitch } from '../../shell/theme';

const kKinds = [
  ['position', 'Position, m'],
  ['height', 'Height, m'],
  ['speed', 'Speed, m/s'],
] as const;

// While the motion plays, the values follow it at this interval.
const kDrawMilliseconds = 50;

export interface CurvePanelOptions {
  theme: ThemeSwitch;
  // Initial choice, such as `RHand` or `joint:hips`; empty: the first marker.
  point: string;
  kind: string;
  seek(seconds: number): void;
  // The user has chosen a point.
  chosen(point: string, kind: CurveKind): void;
  // The chosen marker, also that of the URL; -1 for a joint.
  highlight(marker: number): void;
}

// Curves of a marker or joint over time.
export class CurvePanel {
  readonly node: HTMLElement;
  private readonly chart: LineChart;
  private readonly pointHost = element('span');
  private point: HTMLSelectElement | undefined;
  private readonly kind: HTMLSelectElement;
  private readonly values = element('output', { class: 'hint curve-values' });
  private motion: Motion | undefined;
  private curves: readonly Curve[] = [];
  private seconds = 0;
  private drawnAt = -Infinity;

  constructor(private readonly options: CurvePanelOptions) {
    this.chart = new LineChart({
      theme: options.theme,
      label: 'Curves of a marker or joint over time',
      unit: 'm',
      pick: (seconds) => {
        options.seek(seconds);
      },
    });
    this.kind = selectOf(kKinds, kKinds.find(([kind]) => kind === options.kind)?.[0] ?? 'position');
    this.kind.addEventListener('change', () => {
      this.choose();
    });
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Curves' },
      element(
        'div',
        { class: 'row' },
        element('h2', {}, 'Curves'),
        this.pointHost,
        labelled('Curve', this.kind),
        this.values,
      ),
      this.chart.node,
    );
  }

  // Shows a motion whose frames have all arrived.
  setMotion(motion: Motion): void {
    this.motion = motion;
    const options = [
      ...motion.markers.names.map((name) => [name, name] as const),
      ...motion.joints.names.map((name) => [`joint:${name}`, `${name} (joint)`] as const),
    ];
    const select = selectOf(options, this.options.point);
    select.addEventListener('change', () => {
      this.choose();
    });
    this.point = select;
    replaceChildren(this.pointHost, labelled('Point', select));
    const chosen = this.draw();
    if (this.options.point !== '' && chosen) this.options.highlight(chosen.marker);
  }

  setTime(seconds: number, isPlaying = false): void {
    this.seconds = seconds;
    this.chart.setMark(seconds);
    const now = performance.now();
    if (isPlaying && now - this.drawnAt < kDrawMilliseconds) return;
    this.drawnAt = now;
    // A screen reader would read the values of a motion that plays without end.
    this.values.setAttribute('aria-live', isPlaying ? 'off' : 'polite');
    this.showValues();
  }

  dispose(): void {
    this.chart.dispose();
  }

  private choose(): void {
    const chosen = this.draw();
    if (!chosen) return;
    this.options.chosen(chosen.text, this.kindValue);
    this.options.highlight(chosen.marker);
  }

  private get kindValue(): CurveKind {
    return kKinds.find(([kind]) => kind === this.kind.value)?.[0] ?? 'position';
  }

  private get unit(): string {
    return this.kindValue === 'speed' ? 'm/s' : 'm';
  }

  // The values at the moment, which the chart itself shows only to a pointer.
  private showValues(): void {
    if (!this.motion || this.curves.length === 0) return;
    const text = valueText(this.curves, frameAt(this.motion, this.seconds), this.unit);
    if (text !== this.values.textContent) this.values.textContent = text;
  }

  private draw(): { text: string; marker: number } | undefined {
    const { motion } = this;
    const text = this.point?.value ?? '';
    if (!motion || text === '') return undefined;
    const isJoint = text.startsWith('joint:');
    const track: PointTrack = isJoint ? motion.joints : motion.markers;
    const point = track.names.indexOf(isJoint ? text.slice('joint:'.length) : text);
    if (point < 0) return undefined;
    this.curves = curvesOf(track, point, this.kindValue, motion.frameRateHz);
    const times = frameTimes(motion.frameCount, motion.frameRateHz);
    this.chart.setData(times, this.curves, this.unit);
    this.showValues();
    return { text, marker: isJoint ? -1 : point };
  }
}
