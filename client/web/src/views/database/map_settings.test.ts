import { describe, expect, it } from 'vitest';
import { queryOf, settingsOf, type MapSettings } from './map_settings';

function throughUrl(settings: MapSettings): MapSettings {
  const query = new URLSearchParams();
  for (const [name, value] of Object.entries(queryOf(settings))) {
    if (value !== null && value !== '') query.set(name, String(value));
  }
  return settingsOf(new URLSearchParams(query.toString()));
}

describe('settings of the map in the URL', () => {
  it('come back unchanged', () => {
    const settings: MapSettings = {
      layer: 7,
      axes: '13',
      colorBy: 'clip',
      clip: 'walk & <b>',
      leastProbability: 0.25,
      size: 1.5,
      points: false,
      hiddenLabels: ['jump', 'a, b', '', '~', '!', 'ü~%7E'],
      node: 0,
    };
    expect(throughUrl(settings)).toEqual(settings);
  });

  it('are not in the URL if they are defaults', () => {
    const values = Object.values(queryOf(settingsOf(new URLSearchParams())));
    expect(values.every((value) => value === null || value === '')).toBe(true);
  });

  it('ignore values that are not valid', () => {
    const query = new URLSearchParams('layer=-1&axes=99&least=2&size=x&node=1.5&color=red');
    expect(settingsOf(query)).toEqual(settingsOf(new URLSearchParams()));
  });
});
