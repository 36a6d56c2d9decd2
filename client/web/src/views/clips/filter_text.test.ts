import { expect, test } from 'vitest';
import { errorIndex, facetTerm, hasTerm, quoteValue, splitTerms, toggleTerm } from './filter_text';

test('quotes what a filter would read otherwise', () => {
  expect(quoteValue('walk')).toBe('walk');
  expect(quoteValue('07')).toBe('"07"');
  expect(quoteValue('slow walk')).toBe('"slow walk"');
  expect(quoteValue('AND')).toBe('"AND"');
  expect(quoteValue('a"b\\c*')).toBe('"a\\"b\\\\c\\*"');
});

test('toggling a term twice gives the filter back', () => {
  for (const filter of [
    '',
    'label = walk',
    'a = "x AND y" AND (b = 1 OR c = 2)',
    'a = 1 OR b = 2',
  ]) {
    for (const term of [facetTerm('label', 'slow walk'), facetTerm('tags', 'left')]) {
      const added = toggleTerm(filter, term);
      expect(hasTerm(added, term)).toBe(true);
      expect(toggleTerm(added, term)).toBe(filter);
    }
  }
});

test('splits at the outermost AND only', () => {
  expect(splitTerms('a = "x AND y" AND (b = 1 AND c = 2) AND d')).toEqual([
    'a = "x AND y"',
    '(b = 1 AND c = 2)',
    'd',
  ]);
});

test('finds the character of a byte', () => {
  expect(errorIndex('lable = walk', "filter: byte 1: expected a field, got 'lable'")).toBe(0);
  // é has two bytes, so byte 12 is character 11.
  expect(errorIndex('label = "é" x', 'filter: byte 14: expected')).toBe(12);
  expect(errorIndex('label', 'the server is busy')).toBeUndefined();
});
