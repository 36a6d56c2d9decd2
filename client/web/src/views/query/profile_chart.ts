import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { element } from '../../dom/element';
import { lastPart } from '../../api/resource_names';
import { labelName } from '../../drawing/legend';
import type { LabelStyle } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';
import { rangeOf, type Profile } from './profile_series';

const kHeight = 240;
// Lines of a chart; of more clips, those with the highest values.
const kMaxLines = 120;

// The generation probability of each clip over time at one layer (Figs. 13 to 15): lines have the
// colour of the clip's label.
export class ProfileChart {
  readonly node = element('figure', { class: 'profile' });
  private chart: uPlot | undefined;
  private readonly host = element('div');
  private readonly observer: ResizeObserver;

  constructor(
    profile: Profile,
    styles: ReadonlyMap<string, LabelStyle>,
    theme: ThemeSwitch,
    seek: (seconds: number) => void,
  ) {
    const caption = `Layer ${profile.layer}: ${describeProfile(profile)}`;
    this.node.append(element('figcaption', {}, caption), this.host);
    this.host.setAttribute('role', 'img');
    this.host.setAttribute('aria-label', `Generation probability over time. ${caption}`);
    const clips = strongest(profile, kMaxLines);
    const axis: uPlot.Axis = {
      stroke: theme.color('--text'),
      grid: { stroke: theme.color('--line'), width: 1 },
      ticks: { stroke: theme.color('--line'), width: 1 },
    };
    const options: uPlot.Options = {
      width: 400,
      height: kHeight,
      legend: { show: false },
      scales: { x: { time: false } },
      axes: [
        { ...axis, label: 'time (s)', labelSize: 18 },
        { ...axis, label: 'log probability', size: 62, labelSize: 18 },
      ],
      series: [
        {},
        ...clips.map(({ clip, label }) => {
          const style = styles.get(label);
          return {
            label: lastPart(clip),
            stroke: style?.color ?? 'gray',
            dash: style?.dash ?? [],
            width: 1.5,
            points: { show: profile.times.length === 1 },
          };
        }),
      ],
    };
    const data = [profile.times, ...clips.map((clip) => clip.logProbabilities)];
    this.chart = new uPlot(options, data as uPlot.AlignedData, this.host);
    this.chart.over.addEventListener('click', () => {
      const left = this.chart?.cursor.left ?? -1;
      if (left >= 0) seek(this.chart?.posToVal(left, 'x') ?? 0);
    });
    this.observer = new ResizeObserver(() => {
      const width = this.node.clientWidth;
      if (width > 0) this.chart?.setSize({ width, height: kHeight });
    });
    this.observer.observe(this.node);
  }

  dispose(): void {
    this.observer.disconnect();
    this.chart?.destroy();
    this.chart = undefined;
  }
}

// The label that is in front at most windows, as text.
export function describeProfile(profile: Profile): string {
  const wins = new Map<string, number>();
  profile.times.forEach((_, at) => {
    let best: { label: string; value: number } | undefined;
    for (const { label, logProbabilities } of profile.clips) {
      const value = logProbabilities[at] ?? -Infinity;
      if (value > (best?.value ?? -Infinity)) best = { label, value };
    }
    if (best) wins.set(best.label, (wins.get(best.label) ?? 0) + 1);
  });
  const [first] = [...wins].sort((a, b) => b[1] - a[1]);
  if (!first || !rangeOf(profile)) return 'no clip explains the motion';
  return `${labelName(first[0])} is most probable in ${first[1]} of ${profile.times.length} windows`;
}

function strongest(profile: Profile, limit: number): Profile['clips'] {
  if (profile.clips.length <= limit) return profile.clips;
  const peak = (values: readonly (number | null)[]) =>
    values.reduce<number>((high, value) => Math.max(high, value ?? -Infinity), -Infinity);
  const ranked = [...profile.clips].sort(
    (a, b) => peak(b.logProbabilities) - peak(a.logProbabilities),
  );
  return ranked.slice(0, limit);
}
