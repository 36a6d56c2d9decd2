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
