// Colours behind the text of a label, in tables and timelines. Different labels can have the same
// colour; drawings without texts use LabelPalette.

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
