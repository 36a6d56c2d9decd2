import { expect, test } from 'vitest';
import { previousPages, queryOf, stateOf } from './clip_list_state';

function shared(query: Record<string, string>) {
  const values = Object.entries(queryOf(stateOf(new URLSearchParams(query))));
  return Object.fromEntries(values.filter(([, value]) => value !== null && value !== ''));
}

test('the page of the list is in the URL', () => {
  const query = { filter: 'label = walk', order: 'label desc', page: '3', after: 'tOken_-' };
  expect(shared(query)).toEqual(query);
  expect(shared({})).toEqual({});
});

test('a page without a valid number or token is the first', () => {
  const others = [
    { page: '3' },
    { after: 't' },
    { page: '1', after: 't' },
    { page: 'x', after: 't' },
  ];
  for (const query of others) expect(shared(query)).toEqual({});
});

test('the page before is the first one if its token is not known', () => {
  expect(previousPages(['a', 'b'])).toEqual(['a']);
  expect(previousPages(['a'])).toEqual([]);
  expect(previousPages(['', '', 'c'])).toEqual([]);
});
