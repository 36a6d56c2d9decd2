import { describe, expect, it } from 'vitest';
import { filterOf, queryOfSettings, querySettingsOf } from './query_settings';

const settings = {
  clip: '07_01',
  from: 1,
  to: 2.5,
  at: 0.4,
  history: 0.2,
  filter: 'label = walk OR label = "a b"',
  without: false,
  track: 'carries',
  window: 0.8,
  layers: [9, 7],
};

describe('settings of a query in the URL', () => {
  it('come back unchanged', () => {
    const query = new URLSearchParams();
    for (const [name, value] of Object.entries(queryOfSettings(settings))) {
      if (value !== null && value !== '') query.set(name, String(value));
    }
    expect(querySettingsOf(new URLSearchParams(query.toString()))).toEqual(settings);
  });

  it('ignore values that are not valid', () => {
    const query = new URLSearchParams('from=-1&to=x&layers=0,a,3.5&window=');
    expect(querySettingsOf(query)).toEqual(querySettingsOf(new URLSearchParams()));
  });
});

describe('filterOf', () => {
  it('adds the observed clip to the filter of the user', () => {
    expect(filterOf(settings)).toBe(settings.filter);
    expect(filterOf({ ...settings, without: true })).toBe(
      '(label = walk OR label = "a b") AND name != "07_01"',
    );
    expect(filterOf({ ...settings, without: true, filter: ' ' })).toBe('name != "07_01"');
    expect(filterOf({ ...settings, without: true, clip: '', filter: 'x' })).toBe('x');
  });
});
