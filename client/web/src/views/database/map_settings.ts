import { kAllAxes, type Axes } from './projection';

// What the map shows. All of it is in the URL.
export interface MapSettings {
  // From 1; undefined: the bottom layer.
  layer: number | undefined;
  axes: Axes;
  colorBy: 'label' | 'clip';
  // Id of the clip whose graph is shown; empty: the global graph.
  clip: string;
  // Transitions below this probability are not drawn.
  leastProbability: number;
  // Semi-axes of the ellipsoids, in standard deviations.
  size: number;
  points: boolean;
  // Labels that are not drawn.
  hiddenLabels: string[];
  // Id of the chosen node; undefined: none.
  node: number | undefined;
}

// The settings of a URL; values that are not valid are left out.
export function settingsOf(query: URLSearchParams): MapSettings {
  const axes = query.get('axes');
  return {
    layer: integerOf(query.get('layer'), 1),
    axes: kAllAxes.find((known) => known === axes) ?? '123',
    colorBy: query.get('color') === 'clip' ? 'clip' : 'label',
    clip: query.get('clip') ?? '',
    leastProbability: fractionOf(query.get('least'), 0, 0, 1),
    size: fractionOf(query.get('size'), 0.5, 0.05, 2),
    points: query.get('points') !== '0',
    hiddenLabels: (query.get('hide') ?? '')
      .split('~')
      .filter((text) => text !== '')
      .map(labelOf),
    node: integerOf(query.get('node'), 0),
  };
}

// The values of the URL; null for a default.
export function queryOf(settings: MapSettings): Record<string, string | number | null> {
  return {
    layer: settings.layer ?? null,
    axes: settings.axes === '123' ? null : settings.axes,
    color: settings.colorBy === 'label' ? null : settings.colorBy,
    clip: settings.clip,
    least: settings.leastProbability === 0 ? null : settings.leastProbability,
    size: settings.size === 0.5 ? null : settings.size,
    points: settings.points ? null : '0',
    hide: settings.hiddenLabels.map(textOf).join('~'),
    node: settings.node ?? null,
  };
}

function integerOf(text: string | null, least: number): number | undefined {
  return text !== null && /^\d{1,9}$/.test(text) && Number(text) >= least
    ? Number(text)
    : undefined;
}

function fractionOf(text: string | null, other: number, low: number, high: number): number {
  const value = text === null || text === '' ? NaN : Number(text);
  return value >= low && value <= high ? value : other;
}

// A label in a list that `~` separates: `!` begins an empty one, and one with a character that has a
// meaning here.
function textOf(label: string): string {
  return label === '' || /[~!]/.test(label)
    ? `!${encodeURIComponent(label).replaceAll('~', '%7E')}`
    : label;
}

function labelOf(text: string): string {
  if (!text.startsWith('!')) return text;
  try {
    return decodeURIComponent(text.slice(1));
  } catch {
    return text;
  }
}
