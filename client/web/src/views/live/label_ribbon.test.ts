import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { ObserveResponseSchema } from '../../api/messages';
import { LabelHistory, momentOf } from './label_ribbon';

const labels = [
  { label: 'walk', probability: 0.5 },
  { label: 'run', probability: 0.1 },
];

test('unknown motion wins if it is more probable than each label', () => {
  const known = create(ObserveResponseSchema, { frame: 60n, labels, unknownProbability: 0.4 });
  expect(momentOf(known, 60)).toEqual({ time: 1, label: 'walk', probability: 0.5, unknown: false });
  const unknown = create(ObserveResponseSchema, { frame: 60n, labels, unknownProbability: 0.6 });
  expect(momentOf(unknown, 60)).toEqual({ time: 1, label: '', probability: 0.6, unknown: true });
  const none = create(ObserveResponseSchema, { frame: 3n });
  expect(momentOf(none, 60).unknown).toBe(false);
});

test('keeps the last seconds, and begins anew with a restarted stream', () => {
  const history = new LabelHistory(2);
  for (let frame = 0; frame < 600; ++frame) {
    history.add({ time: frame / 60, label: 'walk', probability: 1, unknown: false });
  }
  expect(history.all.length).toBeLessThanOrEqual(122);
  expect(history.all[0]?.time).toBeGreaterThanOrEqual(7.9);
  history.add({ time: 0, label: 'run', probability: 1, unknown: false });
  expect(history.all.length).toBe(1);
});
