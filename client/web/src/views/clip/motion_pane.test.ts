import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { ClipSchema } from '../../api/messages';
import { mayHaveNewMotion } from './motion_pane';

const stored = {
  etag: '5',
  createTime: { seconds: 100n, nanos: 1000 },
  updateTime: { seconds: 200n, nanos: 5000 },
  frameCount: 120,
  durationSeconds: 2,
  sourceReport: 'm, z up',
};
type Values = Partial<typeof stored> & { title?: string; label?: string };
const mayBeNew = (change: Values, before: Values = stored) =>
  mayHaveNewMotion(create(ClipSchema, before), create(ClipSchema, { ...before, ...change }));

test('an edit leaves the motion', () => {
  expect(mayBeNew({})).toBe(false);
  expect(mayBeNew({ etag: '6', title: 'A', updateTime: { seconds: 200n, nanos: 6000 } })).toBe(
    false,
  );
  // The first one.
  const { updateTime, ...unedited } = stored;
  expect(mayBeNew({ etag: '6', label: 'walk', updateTime }, unedited)).toBe(false);
});

test('a clip that is replaced or derived again may have another motion', () => {
  expect(mayBeNew({ etag: '6', createTime: { seconds: 300n, nanos: 0 } })).toBe(true);
  expect(mayBeNew({ etag: '6', frameCount: 119 })).toBe(true);
  // With other mappings, only the etag changes.
  expect(mayBeNew({ etag: '6' })).toBe(true);
  const { updateTime, ...unedited } = stored;
  expect(mayBeNew({ etag: '6' }, unedited)).toBe(true);
  // Followed by an edit.
  const edit = { etag: '7', updateTime: { ...updateTime, seconds: 400n } };
  expect(mayBeNew({ ...edit, createTime: { seconds: 300n, nanos: 0 } })).toBe(true);
  expect(mayBeNew({ ...edit, sourceReport: 'cm, z up' })).toBe(true);
});
