import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { ThemeSwitch } from '../shell/theme';
import type { LineChart as Chart, ChartOptions } from './line_chart';

// A canvas that takes every call; jsdom has none.
const context = new Proxy({} as Record<string, unknown>, {
  get: (target, name: string) =>
    target[name] ?? (name === 'measureText' ? () => ({ width: 8 }) : () => undefined),
  set: (target, name: string, value) => {
    target[name] = value;
    return true;
  },
});

let themed: (() => void) | undefined;

beforeEach(() => {
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(context as never);
  const observer = { observe: () => undefined, disconnect: () => undefined };
  vi.stubGlobal('ResizeObserver', function () {
    return observer;
  });
  vi.stubGlobal('matchMedia', () => new EventTarget());
  vi.stubGlobal('devicePixelRatio', 1);
  const path = { moveTo: () => undefined, lineTo: () => undefined, rect: () => undefined };
  vi.stubGlobal('Path2D', function () {
    return { ...path, arc: () => undefined, closePath: () => undefined };
  });
});
afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
  document.body.replaceChildren();
});

// uPlot commits changes in a microtask.
const drawn = () => new Promise((resolve) => setTimeout(resolve));

async function openChart(options: Partial<ChartOptions> = {}): Promise<Chart> {
  const { LineChart } = await import('./line_chart');
  const theme = {
    color: () => '#000000',
    onChange: (call: () => void) => {
      themed = call;
      return () => undefined;
    },
  } as unknown as ThemeSwitch;
  const chart = new LineChart({ theme, label: 'a chart', unit: 'm', ...options });
  document.body.append(chart.node);
  return chart;
}

const times = (first: number, count: number) => Array.from({ length: count }, (_, i) => first + i);

async function setData(chart: Chart, first: number, count: number, names = ['a']): Promise<void> {
  const x = times(first, count);
  chart.setData(
    x,
    names.map((name) => ({ name, color: '--left', values: x })),
  );
  await drawn();
}

// The range that the chart shows, to 0.5: its mark is hidden outside.
function shownRange(chart: Chart): { min: number; max: number } {
  const mark = () => chart.node.querySelector<HTMLElement>('.chart-mark')!;
  const inside = times(-100, 300).flatMap((i) => {
    chart.setMark(i / 2 + 0.25);
    return mark().hidden ? [] : [i / 2];
  });
  chart.setMark(NaN);
  return { min: inside[0]!, max: inside.at(-1)! + 0.5 };
}

async function press(chart: Chart, ...keys: string[]): Promise<void> {
  for (const key of keys) {
    chart.node.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
    await drawn();
  }
}

test('new values keep the zoom, without a zoom all is shown', async () => {
  const chart = await openChart();
  await setData(chart, 0, 13);
  expect(shownRange(chart)).toEqual({ min: 0, max: 12 });
  await setData(chart, 0, 19);
  expect(shownRange(chart)).toEqual({ min: 0, max: 18 });
  await press(chart, '+');
  expect(shownRange(chart)).toEqual({ min: 3, max: 15 });
  await setData(chart, 0, 25);
  expect(shownRange(chart)).toEqual({ min: 3, max: 15 });
  // The first values are gone.
  await setData(chart, 10, 25);
  expect(shownRange(chart)).toEqual({ min: 10, max: 22 });
  await press(chart, '0');
  await setData(chart, 10, 31);
  expect(shownRange(chart)).toEqual({ min: 10, max: 40 });
  chart.dispose();
});

test('another theme and other lines keep the zoom', async () => {
  const chart = await openChart();
  await setData(chart, 0, 19);
  await press(chart, '+');
  themed?.();
  themed?.();
  await drawn();
  expect(shownRange(chart)).toEqual({ min: 3, max: 15 });
  await setData(chart, 0, 19, ['a', 'b']);
  expect(shownRange(chart)).toEqual({ min: 3, max: 15 });
  await setData(chart, 0, 10, ['a']);
  expect(shownRange(chart)).toEqual({ min: 0, max: 9 });
  chart.dispose();
  themed?.();
  expect(chart.node.childElementCount).toBe(0);
});

test('the axis has at least two numbers', async () => {
  const chart = await openChart({ height: 150 });
  for (let least = 141; least < 142; least += 0.03)
    for (let range = 0.1; range < 1; range *= 1.2) {
      const write = vi.fn();
      context['fillText'] = write;
      chart.setData([0, 1], [{ name: 'a', color: '--left', values: [least, least + range] }]);
      await drawn();
      const numbers = write.mock.calls.filter(([text]: unknown[]) => /^14[0-9]/.test(String(text)));
      expect(numbers.length, `from ${least} to ${least + range}`).toBeGreaterThanOrEqual(2);
    }
  chart.dispose();
});

test('the keys up and down choose lines', async () => {
  const near = vi.fn();
  const chart = await openChart({ near });
  await setData(chart, 0, 5, ['a', 'b', 'c']);
  near.mockClear();
  await press(chart, 'ArrowUp', 'ArrowUp', 'ArrowDown', 'ArrowDown');
  expect(near.mock.calls.map(([line]: unknown[]) => line)).toEqual([0, 1, 0, 2]);
  // Zooming keeps the choice.
  await press(chart, '+', 'ArrowDown');
  expect(near.mock.calls.at(-1)![0]).toBe(1);
  chart.dispose();
});

test('a chart that is removed is not drawn by another theme', async () => {
  const chart = await openChart();
  await setData(chart, 0, 5);
  chart.dispose();
  themed?.();
  expect(chart.node.querySelector('canvas')).toBeNull();
});
