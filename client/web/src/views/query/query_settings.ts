// What is asked. All of it is in the URL; a file is not.
export interface QuerySettings {
  // Id of a clip; empty: a file.
  clip: string;
  // Part of the clip, s; undefined: from the start, to the end.
  from: number | undefined;
  to: number | undefined;
  // Moment of estimation and prediction, s from the start of the observation; undefined: none.
  at: number | undefined;
  // Part before that moment that is used, s.
  history: number;
  filter: string;
  // Leaves the observed clip out of the answer.
  without: boolean;
  // Empty: `action`.
  track: string;
  window: number;
  // Layers of the generation probability; empty: bottom, middle and upper layer.
  layers: number[];
}

export function querySettingsOf(query: URLSearchParams): QuerySettings {
  const layers = (query.get('layers') ?? '').split(',').map(Number);
  return {
    clip: query.get('clip') ?? '',
    from: numberOf(query.get('from')),
    to: numberOf(query.get('to')),
    at: numberOf(query.get('at')),
    history: numberOf(query.get('history')) ?? 0.4,
    filter: query.get('filter') ?? '',
    without: query.get('without') !== '0',
    track: query.get('track') ?? '',
    window: numberOf(query.get('window')) ?? 0.4,
    layers: layers.filter((layer) => Number.isInteger(layer) && layer >= 1),
  };
}

export function queryOfSettings(settings: QuerySettings): Record<string, string | number | null> {
  return {
    clip: settings.clip,
    from: settings.from ?? null,
    to: settings.to ?? null,
    at: settings.at === undefined ? null : Number(settings.at.toFixed(4)),
    history: settings.history === 0.4 ? null : settings.history,
    filter: settings.filter,
    without: settings.without ? null : '0',
    track: settings.track,
    window: settings.window === 0.4 ? null : settings.window,
    layers: settings.layers.join(','),
  };
}

// The filter of a query: that of the user and, if the observed clip is left out, all other clips.
export function filterOf(settings: QuerySettings): string {
  const { clip, filter, without } = settings;
  if (clip === '' || !without) return filter;
  const others = `name != ${JSON.stringify(clip)}`;
  return filter.trim() === '' ? others : `(${filter}) AND ${others}`;
}

function numberOf(text: string | null): number | undefined {
  const value = text === null || text.trim() === '' ? NaN : Number(text);
  return Number.isFinite(value) && value >= 0 ? value : undefined;
}
