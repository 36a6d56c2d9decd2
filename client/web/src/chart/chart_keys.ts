import { pinchedRange, type ChartRange } from './chart_pinch';

const kZoom = 1.5;

// The range of a chart after a key: + and - zoom about a place, or the middle if the place is not in
// the range; 0 shows all. Undefined for other keys.
export function rangeAfterKey(
  key: string,
  range: ChartRange,
  place: number,
  all: ChartRange,
): ChartRange | undefined {
  if (key === '0') return all;
  const zoom = key === '+' || key === '=' ? kZoom : key === '-' ? 1 / kZoom : undefined;
  if (zoom === undefined) return undefined;
  const part = (place - range.min) / (range.max - range.min);
  const at = part >= 0 && part <= 1 ? part : 0.5;
  // Two fingers beside the place, on a chart of the width 1.
  const [before, after] = [0.1, 0.1 * zoom];
  return pinchedRange(range, [at - before, at + before], [at - after, at + after], 1, all);
}
