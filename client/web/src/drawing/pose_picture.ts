import { svgElement } from '../dom/element';

// Markers of one pose and the lines between them. Positions: x ahead, y left, z up, m.
export interface Pose {
  positions: Float32Array;
  // m/s; drawn as lines.
  velocities?: Float32Array;
  bones: readonly { fromPoint: number; toPoint: number }[];
}

// Size of a picture and how it looks at the pose.
export interface PoseView {
  width: number;
  height: number;
  // Direction of view about the vertical axis, rad; 0 looks at the front of the figure.
  turn: number;
}

// Length of a line for a velocity, s.
const kVelocitySeconds = 0.1;

// A pose as SVG: bones, markers (class `marker`) and velocities (class `velocity`). Positions in
// the picture are those of `posePoints`. Missing markers are left out.
export function posePicture(pose: Pose, view: PoseView, title: string): SVGSVGElement {
  const { points, ends } = posePoints(pose, view);
  const svg = svgElement('svg', {
    class: 'pose',
    viewBox: `0 0 ${view.width} ${view.height}`,
    role: 'img',
    'aria-label': title,
  });
  for (const { fromPoint, toPoint } of pose.bones) {
    appendLine(svg, 'bone', points, fromPoint, points, toPoint);
  }
  for (let i = 0; i < points.length / 2; ++i) {
    const x = points[2 * i]!;
    const y = points[2 * i + 1]!;
    if (Number.isNaN(x)) continue;
    if (ends) appendLine(svg, 'velocity', points, i, ends, i);
    svg.append(svgElement('circle', { class: 'marker', cx: x, cy: y, r: 2.2 }));
  }
  return svg;
}

// Places of markers in a picture, x and y for each, and of the ends of their velocities.
export function posePoints(
  pose: Pose,
  view: PoseView,
): { points: Float32Array; ends: Float32Array | undefined } {
  const { positions, velocities } = pose;
  let height = 0.5;
  for (let i = 2; i < positions.length; i += 3) {
    if (positions[i]! > height) height = positions[i]!;
  }
  const scale = (0.86 * view.height) / Math.max(height, 0.1);
  const place = (values: Float32Array, out: Float32Array) => {
    const c = Math.cos(view.turn);
    const s = Math.sin(view.turn);
    for (let i = 0; 3 * i < values.length; ++i) {
      const across = s * values[3 * i]! + c * values[3 * i + 1]!;
      out[2 * i] = view.width / 2 + scale * across;
      out[2 * i + 1] = 0.94 * view.height - scale * values[3 * i + 2]!;
    }
    return out;
  };
  const size = (positions.length / 3) * 2;
  const points = place(positions, new Float32Array(size));
  if (!velocities) return { points, ends: undefined };
  const moved = positions.map((value, i) => value + kVelocitySeconds * (velocities[i] ?? 0));
  return { points, ends: place(moved, new Float32Array(size)) };
}

function appendLine(
  svg: SVGSVGElement,
  name: string,
  from: Float32Array,
  start: number,
  to: Float32Array,
  end: number,
): void {
  const [x1, y1, x2, y2] = [from[2 * start], from[2 * start + 1], to[2 * end], to[2 * end + 1]];
  if (x1 === undefined || x2 === undefined || Number.isNaN(x1) || Number.isNaN(x2)) return;
  svg.append(svgElement('line', { class: name, x1, y1: y1!, x2, y2: y2! }));
}
