import { pinchedRange } from './chart_pinch';
import type { ChartRange, ZoomTarget } from './chart_range';

const kZoom = 1.5;

// The range zoomed about a place, or the middle if the place is not in the range.
export function zoomedAbout(
  range: ChartRange,
  factor: number,
  place: number,
  all: ChartRange,
): ChartRange {
  const part = (place - range.min) / (range.max - range.min);
  const at = part >= 0 && part <= 1 ? part : 0.5;
  // Two fingers beside the place, on a chart of the width 1.
  const [before, after] = [0.1, 0.1 * factor];
  return pinchedRange(range, [at - before, at + before], [at - after, at + after], 1, all);
}

// The range of a chart after a key: + and - zoom about a place; 0 shows all. Undefined for other keys.
export function rangeAfterKey(
  key: string,
  range: ChartRange,
  place: number,
  all: ChartRange,
): ChartRange | undefined {
  if (key === '0') return all;
  const zoom = key === '+' || key === '=' ? kZoom : key === '-' ? 1 / kZoom : undefined;
  return zoom === undefined ? undefined : zoomedAbout(range, zoom, place, all);
}

// The keys of a node that has the focus zoom about a place.
export function zoomByKeys(
  node: HTMLElement | SVGElement,
  target: ZoomTarget,
  place: () => number,
): void {
  const press = (event: KeyboardEvent) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const ranges = target.ranges();
    const range = ranges && rangeAfterKey(event.key, ranges.shown, place(), ranges.all);
    if (!range) return;
    event.preventDefault();
    target.show(range);
  };
  node.addEventListener('keydown', press as EventListener);
}
