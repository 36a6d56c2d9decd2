import type uPlot from 'uplot';

export interface ChartRange {
  min: number;
  max: number;
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
  const span = Math.min(scale * (range.max - range.min), all.max - all.min);
  const least = range.min + perPixel * (from - scale * after[0]);
  const min = Math.min(Math.max(least, all.min), all.max - span);
  return { min, max: min + span };
}

// Two fingers zoom and move a chart along x; uPlot itself knows only the mouse. A double tap shows
// everything again.
export function zoomByTouch(chart: uPlot): void {
  const { over } = chart;
  const fingers = new Map<number, number>();
  const placeOf = (event: PointerEvent) => event.clientX - over.getBoundingClientRect().left;
  over.addEventListener('pointerdown', (event) => {
    if (event.pointerType === 'touch') fingers.set(event.pointerId, placeOf(event));
  });
  over.addEventListener('pointermove', (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = [...fingers.values()];
    fingers.set(event.pointerId, placeOf(event));
    const after = [...fingers.values()];
    const { min, max } = chart.scales['x'] ?? {};
    const times = chart.data[0];
    if (fingers.size !== 2 || min === undefined || max === undefined) return;
    const all = { min: times[0] ?? min, max: times.at(-1) ?? max };
    const pair = (places: number[]) => [places[0] ?? 0, places[1] ?? 0] as const;
    const width = over.clientWidth;
    chart.setScale('x', pinchedRange({ min, max }, pair(before), pair(after), width, all));
  });
  for (const type of ['pointerup', 'pointercancel', 'pointerleave'] as const)
    over.addEventListener(type, (event) => {
      fingers.delete(event.pointerId);
    });
}
