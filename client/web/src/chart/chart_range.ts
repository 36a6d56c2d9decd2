// The part of an x axis that a picture shows.
export interface ChartRange {
  min: number;
  max: number;
}

// A picture that zooms along x.
export interface ZoomTarget {
  // Undefined: it shows nothing.
  ranges(): { shown: ChartRange; all: ChartRange } | undefined;
  show(range: ChartRange): void;
}

// A range of this size that begins at `min`, moved and shortened to be inside `all`.
export function rangeInside(min: number, size: number, all: ChartRange): ChartRange {
  const span = Math.min(size, all.max - all.min);
  const inside = Math.min(Math.max(min, all.min), all.max - span);
  return { min: inside, max: inside + span };
}
