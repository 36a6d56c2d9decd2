// Text of filters (docs/filters.md).

// A value as it is written in a filter: quoted if it is not a plain word.
export function quoteValue(value: string): string {
  if (/^[A-Za-z_][A-Za-z0-9_-]*$/.test(value) && !/^(AND|OR|NOT|true|false)$/.test(value))
    return value;
  const escaped = value
    .replace(/[\\"*]/g, '\\$&')
    .replace(/\n/g, '\\n')
    .replace(/\t/g, '\\t')
    .replace(/\r/g, '\\r');
  return `"${escaped}"`;
}

// A comparison of a facet's field with one of its values.
export function facetTerm(field: string, value: string): string {
  return `${field} ${field === 'tags' ? ':' : '='} ${quoteValue(value)}`;
}

// The filter with a term added, or without it if it is already there as a part of its own. OR binds
// tighter than AND, so the other parts need no parentheses.
export function toggleTerm(filter: string, term: string): string {
  const parts = splitTerms(filter);
  const index = parts.indexOf(term);
  if (index >= 0) return parts.filter((_, each) => each !== index).join(' AND ');
  return [...parts, term].join(' AND ');
}

export function hasTerm(filter: string, term: string): boolean {
  return splitTerms(filter).includes(term);
}

// The parts of a filter that the outermost AND joins.
export function splitTerms(filter: string): string[] {
  const parts: string[] = [];
  let depth = 0;
  let quote = '';
  let begin = 0;
  for (let index = 0; index < filter.length; ++index) {
    const character = filter[index] ?? '';
    if (quote !== '') {
      if (character === '\\') ++index;
      else if (character === quote) quote = '';
    } else if (character === '"' || character === "'") quote = character;
    else if (character === '(') ++depth;
    else if (character === ')') --depth;
    else if (depth === 0 && filter.startsWith(' AND ', index)) {
      parts.push(filter.slice(begin, index).trim());
      begin = index + ' AND '.length;
      index = begin - 1;
    }
  }
  parts.push(filter.slice(begin).trim());
  return parts.filter((part) => part !== '');
}

// Index in the text of a byte of its UTF-8 form, counted from 1 as in errors; undefined if the
// message names none.
export function errorIndex(text: string, message: string): number | undefined {
  const found = /filter: byte (\d+):/.exec(message);
  if (!found) return undefined;
  let bytes = Number(found[1]) - 1;
  let index = 0;
  const encoder = new TextEncoder();
  for (const character of text) {
    if (bytes <= 0) break;
    bytes -= encoder.encode(character).length;
    index += character.length;
  }
  return index;
}
