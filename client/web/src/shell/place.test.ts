import { expect, test } from 'vitest';
import { hrefOf, parsePlace } from './place';

test('a place survives its URL', () => {
  const place = {
    view: 'clip',
    database: 'demo',
    path: ['wa/lk &?#', '歩行'],
    query: { t: '1.5', filter: 'label = "a&b"' },
  };
  const parsed = parsePlace(hrefOf(place));
  expect(parsed.view).toBe('clip');
  expect(parsed.database).toBe('demo');
  expect(parsed.path).toEqual(place.path);
  expect(Object.fromEntries(parsed.query)).toEqual(place.query);
});

test('an empty or broken fragment is a place too', () => {
  expect(parsePlace('').view).toBe('');
  expect(parsePlace('#/').view).toBe('');
  expect(parsePlace('#/clips/%E0%A4%A').database).toBe('%E0%A4%A');
  expect(hrefOf({ view: 'admin' })).toBe('#/admin');
});
