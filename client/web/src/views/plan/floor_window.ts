import type { FingerMove } from '../../dom/fingers';
import type { FloorXY } from './floor_geometry';

// The part of the floor that a picture shows. Up in the picture is x (front), left is y.
export interface FloorWindow {
  centre: FloorXY;
  // Pixels for each metre.
  scale: number;
  width: number;
  height: number;
}

// Position in the picture, px from the top left.
export function toPicture(window: FloorWindow, point: FloorXY): { left: number; top: number } {
  return {
    left: window.width / 2 - (point.y - window.centre.y) * window.scale,
    top: window.height / 2 - (point.x - window.centre.x) * window.scale,
  };
}

// The point on the floor at a position in the picture.
export function toFloor(window: FloorWindow, left: number, top: number): FloorXY {
  return {
    x: window.centre.x - (top - window.height / 2) / window.scale,
    y: window.centre.y - (left - window.width / 2) / window.scale,
  };
}

// Zooms so that the point of the floor below (left, top) stays there; 4 to 4000 px for each m.
export function zoomAt(
  window: FloorWindow,
  factor: number,
  left: number,
  top: number,
): FloorWindow {
  const fixed = toFloor(window, left, top);
  const scale = Math.min(4000, Math.max(4, window.scale * factor));
  const moved = toFloor({ ...window, scale }, left, top);
  const centre = {
    x: window.centre.x + fixed.x - moved.x,
    y: window.centre.y + fixed.y - moved.y,
  };
  return { ...window, scale, centre };
}

// Moves and zooms as fingers do: the points of the floor below them stay there.
export function pinchWindow(window: FloorWindow, move: FingerMove): FloorWindow {
  const by = { x: move.y / window.scale, y: move.x / window.scale };
  return zoomAt(moveWindow(window, by), move.factor, move.middle.x, move.middle.y);
}

// Moves the picture over the floor, in m.
export function moveWindow(window: FloorWindow, by: FloorXY): FloorWindow {
  return { ...window, centre: { x: window.centre.x + by.x, y: window.centre.y + by.y } };
}

// The point of the 0.1 m grid at the middle of the picture.
export function gridCentre({ centre }: FloorWindow): FloorXY {
  return { x: Math.round(10 * centre.x) / 10, y: Math.round(10 * centre.y) / 10 };
}

// Moves the picture to a point that is outside.
export function keepInside(window: FloorWindow, point: FloorXY): FloorWindow {
  const { left, top } = toPicture(window, point);
  const inside = left >= 0 && left <= window.width && top >= 0 && top <= window.height;
  return inside ? window : { ...window, centre: point };
}

// Shows all points with a margin of 0.7 m; never closer than 6 m across.
export function fitWindow(points: readonly FloorXY[], width: number, height: number): FloorWindow {
  const xs = points.map((point) => point.x);
  const ys = points.map((point) => point.y);
  const [lowX, highX] = [Math.min(0, ...xs), Math.max(0, ...xs)];
  const [lowY, highY] = [Math.min(0, ...ys), Math.max(0, ...ys)];
  const across = Math.max(4.6, highY - lowY) + 1.4;
  const along = Math.max(2.6, highX - lowX) + 1.4;
  return {
    centre: { x: (lowX + highX) / 2, y: (lowY + highY) / 2 },
    scale: Math.min(width / across, height / along),
    width,
    height,
  };
}

// Distance of grid lines: 1, 2 or 5 times a power of 10, at least 40 px apart.
export function gridStep(window: FloorWindow): number {
  const least = 40 / window.scale;
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((factor) => factor * power).find((step) => step >= least * 0.999)!;
}
