import { element } from '../dom/element';
import type { LabelStyle } from './palette';

// A small square of a colour.
export function swatch(color: string): HTMLElement {
  const node = element('span', { class: 'swatch', 'aria-hidden': 'true' });
  node.style.backgroundColor = color;
  return node;
}

// A label with its colour, for each of the labels, in order of name.
export function legendEntries(
  labels: Iterable<string>,
  styles: ReadonlyMap<string, LabelStyle>,
): HTMLElement[] {
  return [...new Set(labels)]
    .sort()
    .map((label) =>
      element(
        'span',
        { class: 'legend-clip' },
        swatch(styles.get(label)?.color ?? 'gray'),
        labelName(label),
      ),
    );
}

// A label as text.
export function labelName(label: string): string {
  return label === '' ? '(no label)' : label;
}

// Number of colours behind the text of labels, in tables and timelines. Different labels can have the
// same colour; drawings without texts use LabelPalette.
export const kLabelColorCount = 12;

// Number of the colour of a label, 0 to kLabelColorCount - 1.
export function labelColorIndex(label: string): number {
  let hash = 2166136261;
  for (const character of label) {
    hash ^= character.codePointAt(0) ?? 0;
    hash = Math.imul(hash, 16777619);
  }
  return (hash >>> 0) % kLabelColorCount;
}

// Class that gives an element the colour of a label.
export function labelClass(label: string): string {
  return `label-${labelColorIndex(label)}`;
}
