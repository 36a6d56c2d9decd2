import { create } from '@bufbuild/protobuf';
import { timestampDate } from '@bufbuild/protobuf/wkt';
import { expect, test } from 'vitest';
import { ClipSchema } from '../../api/messages';
import { changedPaths, clipOf, valuesOf } from './clip_values';

const clip = create(ClipSchema, {
  title: 'A jump',
  description: 'Two lines\nof text',
  tags: ['indoor', 'slow'],
  fields: {
    take: { value: { case: 'number', value: 3 } },
    good: { value: { case: 'flag', value: false } },
    actor: { value: { case: 'text', value: 'A "B" <C>' } },
    day: { value: { case: 'time', value: { seconds: 1_700_000_000n, nanos: 0 } } },
  },
});

test('values survive editing', () => {
  const values = valuesOf(clip);
  expect(values.fields.map((field) => field.name)).toEqual(['actor', 'day', 'good', 'take']);
  const { title, description, tags, fields } = clip;
  expect(clipOf(values)).toEqual({ title, description, tags, fields });
  expect(changedPaths(values, valuesOf(clip))).toEqual([]);
});

test('only changed values are sent', () => {
  const values = valuesOf(clip);
  const edited = { ...values, tags: 'indoor', fields: values.fields.slice(1) };
  expect(changedPaths(values, edited)).toEqual(['tags', 'fields']);
});

test('tags have spaces or commas between them', () => {
  expect(clipOf({ ...valuesOf(clip), tags: ' a, b  c ' }).tags).toEqual(['a', 'b', 'c']);
});

test('a field that is not valid is an error that names it', () => {
  const withField = (kind: 'number' | 'flag' | 'time', text: string) => () =>
    clipOf({ ...valuesOf(clip), fields: [{ name: 'mass', kind, text }] });
  expect(withField('number', '7,5')).toThrow("Field mass: expected a number, got '7,5'.");
  expect(withField('number', '')).toThrow('expected a number');
  expect(withField('flag', 'yes')).toThrow('expected true or false');
  expect(withField('time', 'today')).toThrow('expected a time');
  const twice = { name: 'a', kind: 'text', text: 'b' } as const;
  expect(() => clipOf({ ...valuesOf(clip), fields: [twice, twice] })).toThrow('got two');
  const nameless = { name: '', kind: 'text', text: 'b' } as const;
  expect(() => clipOf({ ...valuesOf(clip), fields: [nameless] })).toThrow('Expected a name');
});

test('a time has Z or an offset', () => {
  const milliseconds = (text: string) => {
    const { day } = clipOf({
      ...valuesOf(clip),
      fields: [{ name: 'day', kind: 'time', text }],
    }).fields;
    if (day?.value.case !== 'time') throw new Error('no time');
    return timestampDate(day.value.value).getTime();
  };
  const noon = Date.UTC(2026, 4, 1, 12);
  expect(milliseconds('2026-05-01T12:00:00Z')).toBe(noon);
  expect(milliseconds(' 2026-05-01t12:00:00.250z ')).toBe(noon + 250);
  expect(milliseconds('2026-05-01T14:00:00+02:00')).toBe(noon);
  expect(milliseconds('2026-05-01T06:30:00-05:30')).toBe(noon);
  // Local times, years, and days that are not there.
  for (const text of [
    '2026-05-01T12:00:00',
    '2026-05-01T12:00',
    '2026-05-01',
    '5',
    'May 1 2026 12:00:00Z',
    '2026-02-30T12:00:00Z',
    '2026-05-01T25:00:00Z',
    '2026-13-01T12:00:00Z',
    '',
  ])
    expect(() => milliseconds(text)).toThrow('Field day: expected a time with Z or an offset');
});
