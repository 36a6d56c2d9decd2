import type { Mapping, SourcePoint } from '../../api/messages';

// Texts of mappings in the marker-set format (docs/file_formats.md).

// How a marker is computed, as after `MARKER =`; empty: by the default rule of the marker set.
export interface MarkerRule {
  marker: string;
  rule: string;
}

// A name as it is written in a mapping: in quotes if it has other characters than plain words.
export function quoteName(name: string): string {
  return /^[A-Za-z_][A-Za-z0-9_]*$/.test(name) ? name : `"${name.replaceAll('"', '""')}"`;
}

// The rules of the markers: those in the text of a mapping, else the point with the marker's name.
export function rulesOf(
  markers: readonly string[],
  points: readonly SourcePoint[],
  text: string,
): MarkerRule[] {
  const written = new Map<string, string>();
  for (const line of text.split('\n')) {
    const found =
      /^\s*("(?:[^"]|"")+"|[^\s#="]+)\s*=\s*((?:"(?:[^"]|"")*"|[^#"])*?)\s*(?:#.*)?$/.exec(line);
    if (found?.[1] !== undefined) written.set(unquoteName(found[1]), found[2] ?? '');
  }
  return markers.map((marker) => {
    const own = points.some((point) => point.name === marker) ? quoteName(marker) : '';
    return { marker, rule: written.get(marker) ?? own };
  });
}

// A file with one mapping.
export function mappingFile(
  name: string,
  rules: readonly MarkerRule[],
  points: readonly SourcePoint[],
  mappings: readonly Mapping[],
): string {
  const signature = signatureOf(name, rules, points, mappings);
  return [
    'motiondb-marker-set 1',
    `mapping ${quoteName(name)}`,
    `signature ${signature.map(quoteName).join(' ')}`,
    ...rules
      .filter(({ rule }) => rule.trim() !== '')
      .map(({ marker, rule }) => `${quoteName(marker)} = ${rule.trim()}`),
    '',
  ].join('\n');
}

// All points of the motion that the rules name, and those of the other `mappings` that fit: the server
// uses the mapping with the longest signature, of equally long ones the one that was added last.
function signatureOf(
  name: string,
  rules: readonly MarkerRule[],
  points: readonly SourcePoint[],
  mappings: readonly Mapping[],
): string[] {
  const names = new Set(points.map((point) => point.name));
  const markers = rules.map(({ marker }) => marker);
  const signatures = [
    ...mappings.filter((other) => other.name !== name).map(({ signature }) => signature),
    markers, // a motion with the markers of the set needs no mapping
  ].filter((signature) => signature.every((point) => names.has(point)));
  const signed = new Set([...rules.flatMap(({ rule }) => pointsOf(rule)), ...signatures.flat()]);
  return points.map((point) => point.name).filter((point) => signed.has(point));
}

// Names of the points in a rule.
export function pointsOf(rule: string): string[] {
  const words = rule.match(/"(?:[^"]|"")*"|[^\s+]+/g) ?? [];
  return words.filter((word) => Number.isNaN(Number(word)) && word !== 'offset').map(unquoteName);
}

// Name of a mapping for a file: its last part without extensions. A number is added if one of the
// stored `mappings` has this name and another signature, because it can be that of another rig.
export function mappingNameOf(
  fileName: string,
  rules: readonly MarkerRule[],
  points: readonly SourcePoint[],
  mappings: readonly Mapping[],
): string {
  const base = plainNameOf(fileName);
  for (let number = 1; ; ++number) {
    const name = number === 1 ? base : `${base}-${number}`;
    const stored = mappings.find((mapping) => mapping.name === name);
    const signature = signatureOf(name, rules, points, mappings);
    if (!stored || sorted(stored.signature) === sorted(signature)) return name;
  }
}

function sorted(names: readonly string[]): string {
  return JSON.stringify([...names].sort());
}

function plainNameOf(fileName: string): string {
  const stem = fileName.replace(/^.*\//, '').replace(/(\.[A-Za-z0-9]{1,5}){1,2}$/, '');
  return `page-${stem.replace(/[^A-Za-z0-9_-]+/g, '_').slice(0, 50)}`;
}

function unquoteName(name: string): string {
  return name.startsWith('"') ? name.slice(1, -1).replaceAll('""', '"') : name;
}
