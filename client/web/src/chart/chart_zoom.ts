// Zooms the x axis of pictures with keys, wheel and fingers.

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

const kKeyZoom = 1.5;

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
  const zoom = key === '+' || key === '=' ? kKeyZoom : key === '-' ? 1 / kKeyZoom : undefined;
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

// The wheel zooms a picture about the pointer, and moves it with Shift or sideways. If nothing
// changes, because all is shown, the wheel scrolls the page.
export function zoomByWheel(node: HTMLElement | SVGElement, target: ZoomTarget): void {
  const turn = (event: WheelEvent) => {
    const ranges = target.ranges();
    if (!ranges) return;
    const { shown, all } = ranges;
    const box = node.getBoundingClientRect();
    const size = shown.max - shown.min;
    const width = Math.max(box.width, 1);
    const sideways = event.shiftKey ? event.deltaX + event.deltaY : event.deltaX;
    const along = event.shiftKey ? 0 : event.deltaY;
    const moved = rangeInside(shown.min + (sideways / width) * size, size, all);
    const place = moved.min + ((event.clientX - box.left) / width) * size;
    const range = zoomedAbout(moved, Math.exp(-along / 500), place, all);
    const change = Math.abs(range.min - shown.min) + Math.abs(range.max - shown.max);
    if (change < 1e-9 * size) return;
    event.preventDefault();
    target.show(range);
  };
  node.addEventListener('wheel', turn as EventListener, { passive: false });
}
