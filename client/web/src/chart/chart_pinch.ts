import { rangeInside, type ChartRange, type ZoomTarget } from './chart_range';

// The range with which what was at the places `before` is at `after`, in px from the left end of a
// plot of this width; at most `all`. Fingers at one place change nothing.
export function pinchedRange(
  range: ChartRange,
  before: readonly [number, number],
  after: readonly [number, number],
  width: number,
  all: ChartRange,
): ChartRange {
  const perPixel = (range.max - range.min) / Math.max(width, 1);
  const [from, to] = before;
  const scale = (to - from) / (after[1] - after[0]);
  if (!(scale > 0) || !Number.isFinite(scale)) return range;
  const least = range.min + perPixel * (from - scale * after[0]);
  return rangeInside(least, scale * (range.max - range.min), all);
}

// Two fingers on a node zoom and move a picture along x.
export function zoomByTouch(node: Element, target: ZoomTarget): void {
  const fingers = new Map<number, number>();
  const listen = (type: string, call: (event: PointerEvent) => void) => {
    node.addEventListener(type, call as EventListener);
  };
  const placeOf = (event: PointerEvent) => event.clientX - node.getBoundingClientRect().left;
  listen('pointerdown', (event) => {
    if (event.pointerType === 'touch') fingers.set(event.pointerId, placeOf(event));
  });
  listen('pointermove', (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = [...fingers.values()];
    fingers.set(event.pointerId, placeOf(event));
    const after = [...fingers.values()];
    const ranges = target.ranges();
    if (fingers.size !== 2 || !ranges) return;
    const pair = (places: number[]) => [places[0] ?? 0, places[1] ?? 0] as const;
    const width = node.clientWidth;
    target.show(pinchedRange(ranges.shown, pair(before), pair(after), width, ranges.all));
  });
  for (const type of ['pointerup', 'pointercancel', 'pointerleave'])
    listen(type, (event) => {
      fingers.delete(event.pointerId);
    });
}
