import { create } from '@bufbuild/protobuf';
import { timestampDate, timestampFromDate } from '@bufbuild/protobuf/wkt';
import { FieldValueSchema, type Clip, type FieldValue } from '../../api/messages';

export type FieldKind = 'text' | 'number' | 'flag' | 'time';
export const kFieldKinds: readonly FieldKind[] = ['text', 'number', 'flag', 'time'];

// A field of the user, as it is edited.
export interface FieldText {
  name: string;
  kind: FieldKind;
  text: string;
}

// The editable values of a clip.
export interface ClipValues {
  title: string;
  description: string;
  // Words with spaces or commas between them.
  tags: string;
  fields: FieldText[];
}

export function valuesOf(clip: Clip): ClipValues {
  return {
    title: clip.title,
    description: clip.description,
    tags: clip.tags.join(' '),
    fields: Object.entries(clip.fields)
      .map(([name, value]) => ({ name, ...fieldText(value) }))
      .sort((a, b) => (a.name < b.name ? -1 : 1)),
  };
}

// Values as the server takes them. Throws if a field is not valid; the server checks the rest.
export function clipOf(
  values: ClipValues,
): Pick<Clip, 'title' | 'description' | 'tags' | 'fields'> {
  const fields: Record<string, FieldValue> = {};
  for (const field of values.fields) {
    if (field.name === '' && field.text === '') continue;
    if (field.name === '') throw new Error(`Expected a name of the field '${field.text}'.`);
    if (Object.hasOwn(fields, field.name))
      throw new Error(`Expected one field '${field.name}', got two.`);
    fields[field.name] = fieldValue(field);
  }
  const tags = values.tags.split(/[\s,]+/).filter((tag) => tag !== '');
  return { title: values.title.trim(), description: values.description, tags, fields };
}

// The fields of the clip that the user has changed, for an update mask.
export function changedPaths(before: ClipValues, after: ClipValues): string[] {
  const names = ['title', 'description', 'tags', 'fields'] as const;
  const text = (value: unknown) => JSON.stringify(value);
  return names.filter((name) => text(before[name]) !== text(after[name]));
}

function fieldText({ value }: FieldValue): { kind: FieldKind; text: string } {
  switch (value.case) {
    case 'number':
    case 'flag':
      return { kind: value.case, text: String(value.value) };
    case 'time':
      return { kind: 'time', text: timestampDate(value.value).toISOString() };
    default:
      return { kind: 'text', text: value.value ?? '' };
  }
}

function fieldValue({ name, kind, text }: FieldText): FieldValue {
  const expected = (what: string) => new Error(`Field ${name}: expected ${what}, got '${text}'.`);
  if (kind === 'number') {
    const value = Number(text);
    if (text.trim() === '' || !Number.isFinite(value)) throw expected('a number');
    return create(FieldValueSchema, { value: { case: 'number', value } });
  }
  if (kind === 'flag') {
    if (text !== 'true' && text !== 'false') throw expected('true or false');
    return create(FieldValueSchema, { value: { case: 'flag', value: text === 'true' } });
  }
  if (kind === 'time') {
    const value = timeOf(text.trim());
    if (!value)
      throw expected(
        'a time with Z or an offset, such as 2026-05-01T12:00:00Z or 2026-05-01T14:00:00+02:00',
      );
    return create(FieldValueSchema, { value: { case: 'time', value: timestampFromDate(value) } });
  }
  return create(FieldValueSchema, { value: { case: 'text', value: text } });
}

// The moment of an RFC 3339 text; undefined for others. A Date also takes a text without an offset, as
// local time, and days that a month does not have.
function timeOf(text: string): Date | undefined {
  const [, day] =
    /^(\d{4}-\d{2}-\d{2})T\d{2}:\d{2}:\d{2}(?:\.\d+)?(?:Z|[+-]\d{2}:\d{2})$/i.exec(text) ?? [];
  if (day === undefined || new Date(day).getUTCDate() !== Number(day.slice(-2))) return undefined;
  const value = new Date(text.toUpperCase());
  return Number.isNaN(value.getTime()) ? undefined : value;
}
