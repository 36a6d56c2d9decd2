import { zoomedAbout } from './chart_keys';
import { rangeInside, type ZoomTarget } from './chart_range';

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
