import { lastPart } from '../../api/resource_names';
import { LineChart } from '../../chart/line_chart';
import { element } from '../../dom/element';
import { labelName } from '../../drawing/labels';
import type { LabelStyle } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';
import { rangeOf, type ClipProfile, type Profile } from './profile_series';

const kHeight = 240;
// Lines of a chart; of more clips, those with the highest values.
const kMaxLines = 120;
const kNoLine = 'Point at a line, or press the keys up and down, to see its clip.';

// The generation probability of each clip over time at one layer (Figs. 13 to 15): lines have the
// colour of the clip's label. Text names the clip of the nearest line.
export class ProfileChart {
  readonly node = element('figure', { class: 'profile' });
  private readonly chart: LineChart;
  private readonly clips: readonly ClipProfile[];
  private readonly near = element('output', { class: 'hint profile-near' }, kNoLine);

  constructor(
    readonly profile: Profile,
    styles: ReadonlyMap<string, LabelStyle>,
    theme: ThemeSwitch,
    seek: (seconds: number) => void,
  ) {
    const caption = `Layer ${profile.layer}: ${describeProfile(profile)}`;
    this.clips = strongest(profile, kMaxLines);
    this.chart = new LineChart({
      theme,
      label: `Generation probability over time. ${caption}`,
      unit: 'log probability',
      xLabel: 'time (s)',
      legend: false,
      height: kHeight,
      pick: seek,
      near: (line, index) => {
        const clip = line === undefined ? undefined : this.clips[line];
        this.near.textContent = clip ? describeLine(clip, profile.times, index) : kNoLine;
      },
    });
    this.node.append(element('figcaption', {}, caption), this.chart.node, this.near);
    this.setStyles(styles);
  }

  setStyles(styles: ReadonlyMap<string, LabelStyle>): void {
    const lines = this.clips.map(({ clip, label, logProbabilities }) => {
      const { color = 'gray', dash = [] } = styles.get(label) ?? {};
      return { name: lastPart(clip), color, dash, values: logProbabilities };
    });
    this.chart.setData(this.profile.times, lines);
  }

  // Marks a moment of the motion.
  mark(seconds: number): void {
    this.chart.setMark(seconds);
  }

  dispose(): void {
    this.chart.dispose();
    this.node.remove();
  }
}

// A clip, its label, and its value at the index, or else its highest one.
export function describeLine(
  { clip, label, logProbabilities }: ClipProfile,
  times: readonly number[],
  index: number | undefined,
): string {
  const name = `${lastPart(clip)} (${labelName(label)})`;
  const values = logProbabilities.map((value) => value ?? -Infinity);
  const at = index ?? values.indexOf(Math.max(...values));
  const value = logProbabilities[at];
  const time = times[at];
  if (value === undefined || value === null || time === undefined) return name;
  const place = index === undefined ? 'highest at' : 'at';
  return `${name}: ${value.toFixed(1)} ${place} ${time.toFixed(2)} s`;
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
