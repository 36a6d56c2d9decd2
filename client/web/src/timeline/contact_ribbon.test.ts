import { afterEach, expect, test, vi } from 'vitest';
import { recordRectangles } from '../drawing/test_canvas';
import type { ThemeSwitch } from '../shell/theme';
import { ContactRibbon, runsOf } from './contact_ribbon';

afterEach(() => {
  vi.restoreAllMocks();
});

const contacts = Uint8Array.from([1, 3, 2, 0, 2, 1]);

test('finds the runs of a bit', () => {
  expect(runsOf(contacts, 1)).toEqual([
    [0, 2],
    [5, 6],
  ]);
  expect(runsOf(contacts, 2)).toEqual([
    [1, 3],
    [4, 5],
  ]);
  expect(runsOf(new Uint8Array(0), 1)).toEqual([]);
});

// A ribbon and what it has drawn.
function openRibbon() {
  const theme = { suffix: '', changed: vi.fn() };
  const ribbon = new ContactRibbon({
    color: (name: string) => `${name}${theme.suffix}`,
    onChange: (listener: () => void) => {
      theme.changed.mockImplementation(listener);
      return () => undefined;
    },
  } as unknown as ThemeSwitch);
  return { ribbon, theme, drawn: recordRectangles() };
}

test('the left foot is the upper stripe and the right foot the lower one', () => {
  const { ribbon, theme, drawn } = openRibbon();
  ribbon.draw(contacts);
  // 1200 px for 6 frames.
  const upper = { y: 0, height: 7, color: '--left' };
  const lower = { y: 8, height: 7, color: '--right' };
  const expected = [
    { x: 0, width: 400, ...upper },
    { x: 1000, width: 200, ...upper },
    { x: 200, width: 400, ...lower },
    { x: 800, width: 200, ...lower },
  ];
  expect(drawn).toEqual(expected);
  theme.suffix = ' of the other theme';
  theme.changed();
  expect(drawn.map(({ color }) => color)).toEqual(
    expected.map(({ color }) => `${color} of the other theme`),
  );
});

test('a short contact of a long motion is visible', () => {
  const { ribbon, drawn } = openRibbon();
  ribbon.draw(new Uint8Array(12_000).fill(2, 6000, 6001));
  expect(drawn).toEqual([{ x: 600, y: 8, width: 1, height: 7, color: '--right' }]);
});
