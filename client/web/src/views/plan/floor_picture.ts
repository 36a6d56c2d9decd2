import { replaceChildren, svgElement } from '../../dom/element';
import {
  placesEvery,
  type FloorPosition,
  type FloorXY,
  type ObstacleShape,
} from './floor_geometry';
import { gridStep, toFloor, toPicture, type FloorWindow } from './floor_window';
import type { ObstacleDrawing } from './obstacle_drawing';

// A root path of a planned motion.
export interface FloorPath {
  poses: readonly FloorPosition[];
  frameRateHz: number;
  chosen: boolean;
}

export interface FloorContent {
  start: FloorPosition;
  goal: FloorPosition;
  drawing: ObstacleDrawing;
  // Where keys draw.
  cursor: FloorXY | undefined;
  paths: readonly FloorPath[];
  // The body at the present time.
  body: FloorPosition | undefined;
}

// Draws start, goal, obstacles and paths on the floor as SVG: circles and heading lines every 1/6 s,
// as in Fig. 16.
export function drawFloor(svg: SVGSVGElement, window: FloorWindow, content: FloorContent): void {
  svg.setAttribute('viewBox', `0 0 ${window.width} ${window.height}`);
  const { drawing, cursor, paths, start, goal, body } = content;
  const { obstacles, chosen, draft } = drawing;
  const shapes = obstacles.map((shape, i) =>
    drawObstacle(window, shape, i === chosen ? 'obstacle chosen' : 'obstacle'),
  );
  if (draft) shapes.push(drawObstacle(window, draft, 'obstacle draft'));
  const ordered = [...paths].sort((a, b) => Number(a.chosen) - Number(b.chosen));
  replaceChildren(
    svg,
    drawGrid(window),
    ...shapes,
    ...ordered.map((path) => drawPath(window, path)),
    drawArrow(window, start, 'start'),
    drawArrow(window, goal, 'goal'),
    body ? drawArrow(window, body, 'body') : null,
    cursor ? drawCursor(window, cursor) : null,
  );
}

function drawGrid(window: FloorWindow): SVGGElement {
  const group = svgElement('g', { class: 'grid' });
  const step = gridStep(window);
  const high = toFloor(window, 0, 0);
  const low = toFloor(window, window.width, window.height);
  for (let x = Math.ceil(low.x / step) * step; x <= high.x; x += step) {
    const { top } = toPicture(window, { x, y: 0 });
    group.append(svgElement('line', { x1: 0, x2: window.width, y1: top, y2: top }));
    group.append(svgElement('text', { x: 4, y: top - 3 }, metres(x, step)));
  }
  for (let y = Math.ceil(low.y / step) * step; y <= high.y; y += step) {
    const { left } = toPicture(window, { x: 0, y });
    group.append(svgElement('line', { x1: left, x2: left, y1: 0, y2: window.height }));
    group.append(svgElement('text', { x: left + 3, y: window.height - 4 }, metres(y, step)));
  }
  return group;
}

function drawPath(window: FloorWindow, path: FloorPath): SVGGElement {
  const group = svgElement('g', { class: path.chosen ? 'path chosen' : 'path' });
  const corners = path.poses.map((pose) => pointText(window, pose)).join(' ');
  group.append(svgElement('polyline', { points: corners }));
  if (!path.chosen) return group;
  for (const pose of placesEvery(path.poses, path.frameRateHz)) {
    const { left, top } = toPicture(window, pose);
    const tip = toPicture(window, ahead(pose, 16 / window.scale));
    group.append(
      svgElement('line', { class: 'heading', x1: left, y1: top, x2: tip.left, y2: tip.top }),
      svgElement('circle', { class: 'place', cx: left, cy: top, r: 4 }),
    );
  }
  return group;
}

function drawArrow(window: FloorWindow, pose: FloorPosition, name: string): SVGGElement {
  const { left, top } = toPicture(window, pose);
  const tip = toPicture(window, ahead(pose, 30 / window.scale));
  const side = (turn: number) =>
    pointText(window, ahead({ ...pose, heading: pose.heading + turn }, 20 / window.scale));
  const group = svgElement('g', { class: `pose-mark ${name}` });
  group.append(
    svgElement('line', { x1: left, y1: top, x2: tip.left, y2: tip.top }),
    svgElement('polyline', { points: `${side(0.35)} ${tip.left},${tip.top} ${side(-0.35)}` }),
    svgElement('circle', { cx: left, cy: top, r: 8 }),
    svgElement('text', { x: left + 11, y: top + 16 }, name === 'body' ? '' : name),
  );
  return group;
}

function drawCursor(window: FloorWindow, at: FloorXY): SVGGElement {
  const { left, top } = toPicture(window, at);
  return svgElement(
    'g',
    { class: 'cursor' },
    svgElement('line', { x1: left - 10, x2: left + 10, y1: top, y2: top }),
    svgElement('line', { x1: left, x2: left, y1: top - 10, y2: top + 10 }),
  );
}

function drawObstacle(window: FloorWindow, shape: ObstacleShape, name: string): SVGElement {
  if (shape.kind === 'disc') {
    const { left, top } = toPicture(window, shape.centre);
    return svgElement('circle', { class: name, cx: left, cy: top, r: shape.radius * window.scale });
  }
  const points = shape.corners.map((corner) => pointText(window, corner)).join(' ');
  return svgElement('polygon', { class: name, points });
}

function ahead({ x, y, heading }: FloorPosition, length: number): FloorXY {
  return { x: x + length * Math.cos(heading), y: y + length * Math.sin(heading) };
}

function pointText(window: FloorWindow, point: FloorXY): string {
  const { left, top } = toPicture(window, point);
  return `${left.toFixed(2)},${top.toFixed(2)}`;
}

function metres(value: number, step: number): string {
  return `${value.toFixed(step < 1 ? 1 : 0)} m`;
}
