import { BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments } from 'three';
import type { Scene } from './scene';

// Extent of a motion on the floor, m.
export interface FloorExtent {
  minX: number;
  minY: number;
  maxX: number;
  maxY: number;
}

// Lines on the floor, 1 m apart, in one draw call.
export class FloorObject {
  private readonly geometry = new BufferGeometry();
  private readonly material = new LineBasicMaterial();
  private readonly lines = new LineSegments(this.geometry, this.material);
  private readonly forgetTheme: () => void;

  constructor(
    private readonly scene: Scene,
    extent: FloorExtent = { minX: -3, minY: -3, maxX: 3, maxY: 3 },
  ) {
    this.lines.frustumCulled = false;
    scene.root.add(this.lines);
    this.forgetTheme = scene.onTheme(() =>
      this.material.color.copy(new Color(scene.theme.color('--floor'))),
    );
    this.cover(extent);
  }

  // Covers an extent with a margin of 1 m, at most 60 m x 60 m.
  cover(extent: FloorExtent): void {
    this.geometry.setAttribute('position', new BufferAttribute(floorLines(extent), 3));
    this.scene.invalidate();
  }

  dispose(): void {
    this.forgetTheme();
    this.scene.root.remove(this.lines);
    this.geometry.dispose();
    this.material.dispose();
  }
}

const kMaxMetres = 60;

// End points of the lines: lines x 2 x 3.
export function floorLines(extent: FloorExtent): Float32Array {
  const [x0, x1] = rangeOf(extent.minX, extent.maxX);
  const [y0, y1] = rangeOf(extent.minY, extent.maxY);
  const values: number[] = [];
  for (let x = x0; x <= x1; ++x) values.push(x, y0, 0, x, y1, 0);
  for (let y = y0; y <= y1; ++y) values.push(x0, y, 0, x1, y, 0);
  return new Float32Array(values);
}

// Extent of positions, points x 3; missing points are left out.
export function extentOf(positions: Float32Array): FloorExtent {
  const extent = { minX: Infinity, minY: Infinity, maxX: -Infinity, maxY: -Infinity };
  for (let index = 0; index + 2 < positions.length; index += 3) {
    const x = positions[index] ?? NaN;
    const y = positions[index + 1] ?? NaN;
    if (Number.isNaN(x) || Number.isNaN(y)) continue;
    extent.minX = Math.min(extent.minX, x);
    extent.maxX = Math.max(extent.maxX, x);
    extent.minY = Math.min(extent.minY, y);
    extent.maxY = Math.max(extent.maxY, y);
  }
  return Number.isFinite(extent.minX) ? extent : { minX: -2, minY: -2, maxX: 2, maxY: 2 };
}

function rangeOf(low: number, high: number): [number, number] {
  const middle = (low + high) / 2;
  const half = Math.min(kMaxMetres, high - low) / 2;
  return [Math.floor(middle - half) - 1, Math.ceil(middle + half) + 1];
}
