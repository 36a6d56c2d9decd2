import { expect, test } from 'vitest';
import { runsOf } from './contact_ribbon';

test('finds the runs of a bit', () => {
  const contacts = Uint8Array.from([1, 3, 2, 0, 2, 1]);
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
