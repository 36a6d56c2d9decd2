import { describe, expect, it } from 'vitest';
import type { ThemeName } from '../shell/theme';
import { clipColor, LabelPalette, labelStyles, readableOn, rgbOf } from './palette';

const backgrounds: Record<ThemeName, string> = { light: '#e9edf2', dark: '#1d2127' };

function linear(color: string): number[] {
  return rgbOf(color).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
}

function luminance([r, g, b]: number[]): number {
  return 0.2126 * r! + 0.7152 * g! + 0.0722 * b!;
}

// WCAG contrast ratio.
function contrast(a: string, b: string): number {
  const [high, low] = [luminance(linear(a)), luminance(linear(b))].sort((x, y) => y - x);
  return (high! + 0.05) / (low! + 0.05);
}

// Severity 1 of Machado, Oliveira and Fernandes (2009).
const visions = {
  normal: [1, 0, 0, 0, 1, 0, 0, 0, 1],
  deuteranopia: [0.367, 0.861, -0.228, 0.28, 0.673, 0.047, -0.012, 0.043, 0.969],
  protanopia: [0.152, 1.053, -0.205, 0.115, 0.786, 0.099, -0.004, -0.048, 1.052],
};

function lab(rgb: number[]): number[] {
  const [r, g, b] = rgb.map((v) => Math.min(1, Math.max(0, v)));
  const f = (t: number) => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
  const x = f((0.4124 * r! + 0.3576 * g! + 0.1805 * b!) / 0.9505);
  const y = f(0.2126 * r! + 0.7152 * g! + 0.0722 * b!);
  const z = f((0.0193 * r! + 0.1192 * g! + 0.9505 * b!) / 1.089);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

function seen(color: string, vision: number[]): number[] {
  const rgb = linear(color);
  return lab([0, 3, 6].map((row) => rgb.reduce((sum, v, i) => sum + vision[row + i]! * v, 0)));
}

describe.each(['light', 'dark'] as const)('palette of the %s theme', (theme) => {
  const labels = ['a', 'b', 'c', 'd', 'e', 'f', 'g', 'h'];
  const colors = [...labelStyles(labels, theme).values()].map((style) => style.color);

  it('stands out from the background', () => {
    for (const color of colors)
      expect(contrast(color, backgrounds[theme]), color).toBeGreaterThan(3);
    for (let i = 0; i < 20; ++i) {
      expect(contrast(clipColor(i, 20, theme), backgrounds[theme])).toBeGreaterThan(3);
    }
  });

  it.each(Object.entries(visions))('keeps labels apart with %s vision', (_name, vision) => {
    for (const [i, first] of colors.entries()) {
      for (const second of colors.slice(i + 1)) {
        const a = seen(first, vision);
        const b = seen(second, vision);
        const distance = Math.hypot(...a.map((v, k) => v - b[k]!));
        expect(distance, `${first} ${second}`).toBeGreaterThan(18);
      }
    }
  });
});

describe('labelStyles', () => {
  it.each(['light', 'dark'] as const)('gives each of 24 labels its own %s colour', (theme) => {
    const labels = Array.from({ length: 24 }, (_, i) => `label${i}`);
    const styles = [...labelStyles(labels, theme).values()];
    expect(new Set(styles.map(({ color }) => color)).size).toBe(24);
    expect(new Set(styles.map(({ dash }) => dash.join())).size).toBe(3);
    for (const { color } of styles)
      expect(contrast(color, backgrounds[theme]), color).toBeGreaterThan(3);
  });

  it('keeps the styles of labels when others are added', () => {
    const palette = new LabelPalette(['jump', 'walk']);
    const before = palette.styles('light');
    palette.add(['climb', 'walk']);
    const after = palette.styles('light');
    expect([...after.keys()]).toEqual(['jump', 'walk', 'climb']);
    for (const [label, style] of before) expect(after.get(label)).toEqual(style);
  });

  it('does not depend on the order of the labels', () => {
    expect(labelStyles(['walk', 'jump'], 'dark')).toEqual(labelStyles(['jump', 'walk'], 'dark'));
  });
});

describe.each(['#e9edf2', '#101317'])('readableOn %s', (background) => {
  const hex = (rgb: number[]) =>
    `#${rgb
      .map((v) =>
        Math.round(255 * v)
          .toString(16)
          .padStart(2, '0'),
      )
      .join('')}`;

  it('makes every colour stand out, and keeps those that do', () => {
    for (let i = 0; i < 125; ++i) {
      const color = [i % 5, Math.floor(i / 5) % 5, Math.floor(i / 25)].map((v) => v / 4);
      const shown = readableOn(background, color as [number, number, number]);
      expect(contrast(hex(shown), background), hex(color)).toBeGreaterThan(2.95);
      if (contrast(hex(color), background) > 3.05) expect(shown).toEqual(color);
    }
  });

  it('keeps the hue', () => {
    const [red, green, blue] = readableOn(background, [1, 0, 0]);
    expect(red).toBeGreaterThan(2 * Math.max(green, blue));
  });
});
