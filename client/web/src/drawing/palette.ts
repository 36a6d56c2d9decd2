import type { ThemeName } from '../shell/theme';

// Colours that remain different for colour-blind readers, at least 3:1 against the background.

// How lines and areas of one label look. Labels beyond the colours repeat them in other shades, with
// kDashes.
export interface LabelStyle {
  color: string;
  // Lengths of kDashes and gaps, px; empty: a full line.
  dash: number[];
}

const kCategorical: Record<ThemeName, readonly string[]> = {
  light: ['#26399c', '#ff261c', '#6a9126', '#36113b', '#d00267', '#8867ab', '#084936', '#474ce9'],
  dark: ['#2f5ffa', '#53ef79', '#fff039', '#c0450d', '#c3ddff', '#a79c8e', '#929dff', '#71678f'],
};

const kDashes: readonly number[][] = [[], [6, 3], [2, 2]];
// Difference of two shades of a colour.
const kShade = 0.35;

// From the first to the last clip: Cividis, which is monotonic in lightness.
const kSequential: Record<ThemeName, readonly [number, number, number][]> = {
  light: [
    [0, 34, 78],
    [53, 69, 108],
    [102, 105, 112],
    [126, 124, 108],
    [138, 128, 50],
  ],
  dark: [
    [95, 110, 155],
    [124, 123, 120],
    [165, 156, 116],
    [210, 193, 94],
    [255, 234, 70],
  ],
};

// Labels with their styles, the same in all drawings that share the palette. A label keeps its style
// when others are added.
export class LabelPalette {
  private readonly labels = new Set<string>();

  constructor(labels: Iterable<string> = []) {
    this.add(labels);
  }

  add(labels: Iterable<string>): void {
    for (const label of [...labels].sort()) this.labels.add(label);
  }

  styles(theme: ThemeName): Map<string, LabelStyle> {
    const colors = kCategorical[theme];
    return new Map(
      [...this.labels].map((label, i) => {
        const round = Math.floor(i / colors.length) % kDashes.length;
        const color = shade(colors[i % colors.length]!, kShade * round, theme);
        return [label, { color, dash: kDashes[round]! }];
      }),
    );
  }
}

// The styles of the labels of one drawing.
export function labelStyles(labels: Iterable<string>, theme: ThemeName): Map<string, LabelStyle> {
  return new LabelPalette(labels).styles(theme);
}

// A colour, mixed with `part` of black, or white in the dark theme: it stands out more.
function shade(color: string, part: number, theme: ThemeName): string {
  const end = theme === 'dark' ? 255 : 0;
  return hexColor(rgbOf(color).map((value) => 255 * value + part * (end - 255 * value)));
}

// The colour of the clip at `place` of `count`, `#rrggbb`.
export function clipColor(place: number, count: number, theme: ThemeName): string {
  const anchors = kSequential[theme];
  const at = count > 1 ? (place / (count - 1)) * (anchors.length - 1) : 0;
  const low = Math.min(Math.floor(at), anchors.length - 2);
  const from = anchors[low]!;
  const to = anchors[low + 1]!;
  return hexColor(from.map((value, i) => value + (at - low) * (to[i]! - value)));
}

// Red, green and blue (0 to 1, sRGB) of `#rrggbb`.
export function rgbOf(color: string): [number, number, number] {
  const value = Number.parseInt(color.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

// A colour (red, green and blue, 0 to 1, sRGB), made darker or lighter until its contrast with the
// background, `#rrggbb`, is at least 3:1.
export function readableOn(
  background: string,
  color: readonly [number, number, number],
): [number, number, number] {
  const behind = luminanceOf(rgbOf(background));
  const dark = 1.05 / (behind + 0.05) > (behind + 0.05) / 0.05;
  const isReadable = (luminance: number) =>
    dark ? luminance + 0.05 >= 3 * (behind + 0.05) : 3 * (luminance + 0.05) <= behind + 0.05;
  const mixed = (part: number) =>
    color.map((value) => value + part * ((dark ? 1 : 0) - value)) as [number, number, number];
  const kSteps = 50;
  for (let step = 0; step < kSteps; ++step) {
    const result = mixed(step / kSteps);
    if (isReadable(luminanceOf(result))) return result;
  }
  return mixed(1);
}

// Relative luminance of WCAG.
function luminanceOf(rgb: readonly number[]): number {
  const [r, g, b] = rgb.map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}

function hexColor(rgb: number[]): string {
  return `#${rgb.map((value) => Math.round(value).toString(16).padStart(2, '0')).join('')}`;
}
