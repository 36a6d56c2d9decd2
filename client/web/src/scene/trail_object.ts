import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DynamicDrawUsage,
  LineBasicMaterial,
  LineSegments,
} from 'three';
import type { PointTrack } from '../motion/motion';
import type { Scene } from './scene';

const kSamples = 60;

// The paths of some points before the present frame, in one draw call.
export class TrailObject {
  private readonly geometry = new BufferGeometry();
  private readonly material = new LineBasicMaterial();
  private readonly lines = new LineSegments(this.geometry, this.material);
  private readonly forgetTheme: () => void;
  private points: readonly number[] = [];
  private values = new Float32Array(0);

  constructor(
    private readonly scene: Scene,
    private readonly track: PointTrack,
  ) {
    this.lines.frustumCulled = false;
    this.lines.visible = false;
    scene.root.add(this.lines);
    this.forgetTheme = scene.onTheme(() =>
      this.material.color.copy(new Color(scene.theme.color('--trail'))),
    );
  }

  // Chooses the points with a trail.
  show(points: readonly number[]): void {
    this.points = points;
    this.values = new Float32Array(points.length * kSamples * 2 * 3);
    this.geometry.dispose();
    const attribute = new BufferAttribute(this.values, 3);
    attribute.setUsage(DynamicDrawUsage);
    this.geometry.setAttribute('position', attribute);
    this.lines.visible = points.length > 0;
    this.scene.invalidate();
  }

  // Draws the paths of the last `length` frames before `frame`.
  update(frame: number, length: number): void {
    if (this.points.length === 0) return;
    this.geometry.setDrawRange(
      0,
      fillTrails(this.values, this.track, this.points, frame, length) / 3,
    );
    const attribute = this.geometry.getAttribute('position');
    attribute.needsUpdate = true;
    this.scene.invalidate();
  }

  dispose(): void {
    this.forgetTheme();
    this.scene.root.remove(this.lines);
    this.geometry.dispose();
    this.material.dispose();
  }
}

// Writes line segments of at most kSamples steps a point into `values`; returns the number of
// values. A step with a missing point is left out.
export function fillTrails(
  values: Float32Array,
  track: PointTrack,
  points: readonly number[],
  frame: number,
  length: number,
): number {
  const stride = Math.max(1, Math.ceil(length / kSamples));
  const { positions } = track;
  const size = track.names.length * 3;
  let end = 0;
  for (const point of points) {
    for (let step = 0; step < kSamples; ++step) {
      const later = frame - step * stride;
      const earlier = later - stride;
      if (earlier < 0 || earlier < frame - length) break;
      const a = earlier * size + 3 * point;
      const b = later * size + 3 * point;
      if (Number.isNaN(positions[a] ?? NaN) || Number.isNaN(positions[b] ?? NaN)) continue;
      for (let axis = 0; axis < 3; ++axis) {
        values[end + axis] = positions[a + axis] ?? NaN;
        values[end + 3 + axis] = positions[b + axis] ?? NaN;
      }
      end += 6;
    }
  }
  return end;
}
