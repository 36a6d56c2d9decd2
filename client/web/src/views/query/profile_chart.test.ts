import { beforeEach, expect, test, vi } from 'vitest';
import type { ChartLine, ChartOptions } from '../../chart/line_chart';
import type { ThemeSwitch } from '../../shell/theme';
import { ProfileChart } from './profile_chart';

const charts = vi.hoisted(
  () => [] as { options: ChartOptions; setData: ReturnType<typeof vi.fn> }[],
);

vi.mock('../../chart/line_chart', () => ({
  LineChart: class {
    node = document.createElement('div');
    setData = vi.fn();
    dispose = vi.fn();
    constructor(readonly options: ChartOptions) {
      charts.push(this);
    }
  },
}));

const profile = {
  layer: 3,
  times: [0.2, 0.6, 1],
  clips: [
    { clip: 'databases/d/clips/a', label: 'walk', logProbabilities: [-5, -4.25, -6] },
    { clip: 'databases/d/clips/b', label: '', logProbabilities: [null, -7, null] },
  ],
};
const styles = new Map([['walk', { color: '#123456', dash: [2, 1] }]]);
const theme = {} as ThemeSwitch;

beforeEach(() => {
  charts.length = 0;
});

test('a line for each clip has the colour of its label', () => {
  const chart = new ProfileChart(profile, styles as never, theme, vi.fn());
  const linesOf = () =>
    (charts[0]!.setData.mock.lastCall as [unknown, ChartLine[]])[1].map(
      ({ name, color, dash }) => ({ name, color, dash }),
    );
  expect(linesOf()).toEqual([
    { name: 'a', color: '#123456', dash: [2, 1] },
    { name: 'b', color: 'gray', dash: [] },
  ]);
  // Another theme changes the same chart, which keeps its zoom.
  chart.setStyles(new Map([['walk', { color: '#abcdef', dash: [] }]]) as never);
  expect(charts.length).toBe(1);
  expect(linesOf()[0]!.color).toBe('#abcdef');
});

test('text names the clip of the nearest line', () => {
  const chart = new ProfileChart(profile, styles as never, theme, vi.fn());
  const text = () => chart.node.querySelector('output')!.textContent;
  const { near } = charts[0]!.options;
  expect(text()).toMatch(/^Point at a line/);
  near!(0, 2);
  expect(text()).toBe('a (walk): -6.0 at 1.00 s');
  near!(1, 1);
  expect(text()).toBe('b ((no label)): -7.0 at 0.60 s');
  near!(1, 0);
  expect(text()).toBe('b ((no label))');
  // By keyboard there is no moment.
  near!(0, undefined);
  expect(text()).toBe('a (walk): -4.3 highest at 0.60 s');
  near!(undefined, undefined);
  expect(text()).toMatch(/^Point at a line/);
});
