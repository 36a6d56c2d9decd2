import {
  Color,
  CylinderGeometry,
  Group,
  IcosahedronGeometry,
  InstancedMesh,
  Matrix4,
  type MeshLambertMaterial,
  Quaternion,
  Vector3,
} from 'three';
import { sideOf, linkRadii, type LinkRadii } from './figure_shape';
import type { Scene } from './scene';

export interface FigurePoints {
  readonly names: readonly string[];
  readonly bones: readonly { readonly fromPoint: number; readonly toPoint: number }[];
}

export interface FigureStyle {
  // Radius of a point, m; default 0.022. 0: no points.
  pointRadius?: number;
  // Radius of a bone, m; default 0.009.
  boneRadius?: number;
  // Bones are links of a body: capsules whose radii follow from their lengths, instead of both radii.
  links?: boolean;
  // 0 to 1; default 1.
  opacity?: number;
  // Name of a colour of the style sheet, such as --ghost, for everything or for each point; default:
  // by side of the body.
  color?: string | ((point: number) => string);
}

export interface NearestPoint {
  point: number;
  distance: number; // px
}

const kUp = new Vector3(0, 1, 0);

// Points and bones in two draw calls. A missing point and its bones are not drawn.
export class FigureObject {
  private readonly group = new Group();
  private readonly points: InstancedMesh<IcosahedronGeometry, MeshLambertMaterial>;
  private readonly bones: InstancedMesh<CylinderGeometry, MeshLambertMaterial>;
  private readonly matrix = new Matrix4();
  private readonly from = new Vector3();
  private readonly to = new Vector3();
  private readonly turn = new Quaternion();
  private readonly size = new Vector3();
  private positions: Float32Array = new Float32Array(0);
  private readonly forgetTheme: () => void;
  private radii: LinkRadii | undefined;
  private highlighted = -1;

  constructor(
    private readonly scene: Scene,
    readonly figure: FigurePoints,
    private readonly style: FigureStyle = {},
  ) {
    const material = scene.surface(style.opacity ?? 1);
    this.points = new InstancedMesh(
      new IcosahedronGeometry(1, style.links === true ? 2 : 1),
      material,
      Math.max(1, figure.names.length),
    );
    this.bones = new InstancedMesh(
      new CylinderGeometry(1, 1, 1, style.links === true ? 12 : 6, 1, true),
      material,
      Math.max(1, figure.bones.length),
    );
    for (const mesh of [this.points, this.bones]) {
      mesh.frustumCulled = false;
      mesh.count = 0;
      this.group.add(mesh);
    }
    scene.root.add(this.group);
    this.forgetTheme = scene.onTheme(() => {
      this.applyColors();
    });
  }

  // Shows positions, points x 3, m.
  update(positions: Float32Array): void {
    this.positions = positions;
    if (this.style.links === true) this.radii ??= linkRadii(this.figure, positions);
    this.updatePoints();
    this.updateBones();
  }

  set visible(visible: boolean) {
    this.group.visible = visible;
    this.scene.invalidate();
  }

  get visible(): boolean {
    return this.group.visible;
  }

  // Index of the point next to a place on the canvas, less than `radius` pixels away; otherwise -1.
  pointAt(x: number, y: number, radius = 14): number {
    return this.nearestTo(x, y, radius)?.point ?? -1;
  }

  // The point next to a place on the canvas, less than `radius` pixels away, and its distance.
  nearestTo(x: number, y: number, radius = 14): NearestPoint | undefined {
    let best: NearestPoint | undefined;
    for (let point = 0; point < this.figure.names.length; ++point) {
      const at = this.scene.project(...this.positionOf(point));
      if (!at) continue;
      const distance = Math.hypot(at.x - x, at.y - y);
      if (distance < (best?.distance ?? radius)) best = { point, distance };
    }
    return best;
  }

  positionOf(point: number): [number, number, number] {
    const at = this.positions.subarray(3 * point, 3 * point + 3);
    return [at[0] ?? NaN, at[1] ?? NaN, at[2] ?? NaN];
  }

  // Draws one point larger, in the accent colour; -1: none.
  highlight(point: number): void {
    if (point === this.highlighted) return;
    this.highlighted = point;
    this.applyColors();
    if (this.positions.length > 0) this.updatePoints();
  }

  dispose(): void {
    this.forgetTheme();
    this.scene.root.remove(this.group);
    for (const mesh of [this.points, this.bones]) {
      mesh.geometry.dispose();
      mesh.dispose();
    }
    this.scene.invalidate();
  }

  // Writes the matrices in place: this runs for each picture of a motion that plays.
  private updatePoints(): void {
    const { positions, radii } = this;
    const ofAll = this.style.pointRadius ?? 0.022;
    const count = ofAll > 0 ? Math.min(this.figure.names.length, positions.length / 3) : 0;
    this.points.count = Math.floor(count);
    const matrices = this.points.instanceMatrix.array;
    for (let point = 0; point < this.points.count; ++point) {
      const x = positions[3 * point] ?? NaN;
      const y = positions[3 * point + 1] ?? NaN;
      const z = positions[3 * point + 2] ?? NaN;
      const known = Number.isFinite(x + y + z);
      const radius = radii ? (radii.points[point] ?? 0) : ofAll;
      const size = known ? (point === this.highlighted ? 1.7 * radius : radius) : 0;
      const at = 16 * point;
      matrices[at] = matrices[at + 5] = matrices[at + 10] = size;
      matrices[at + 12] = known ? x : 0;
      matrices[at + 13] = known ? y : 0;
      matrices[at + 14] = known ? z : 0;
      matrices[at + 15] = 1;
    }
    this.points.instanceMatrix.needsUpdate = true;
    this.scene.invalidate();
  }

  private updateBones(): void {
    const { bones } = this.figure;
    this.bones.count = bones.length;
    for (let index = 0; index < bones.length; ++index) this.placeBone(index);
    this.bones.instanceMatrix.needsUpdate = true;
    this.scene.invalidate();
  }

  private placeBone(index: number): void {
    const bone = this.figure.bones[index];
    if (!bone) return;
    const radius = this.radii?.bones[index] ?? this.style.boneRadius ?? 0.009;
    this.readPosition(bone.fromPoint, this.from);
    this.readPosition(bone.toPoint, this.to).sub(this.from);
    const length = this.to.length();
    if (Number.isFinite(length) && length > 0) {
      this.turn.setFromUnitVectors(kUp, this.size.copy(this.to).divideScalar(length));
      this.from.addScaledVector(this.to, 0.5);
      this.matrix.compose(this.from, this.turn, this.size.set(radius, length, radius));
    } else {
      this.matrix.makeScale(0, 0, 0);
    }
    this.bones.setMatrixAt(index, this.matrix);
  }

  private readPosition(point: number, into: Vector3): Vector3 {
    const { positions } = this;
    return into.set(
      positions[3 * point] ?? NaN,
      positions[3 * point + 1] ?? NaN,
      positions[3 * point + 2] ?? NaN,
    );
  }

  private applyColors(): void {
    const theme = this.scene.theme;
    const sides = {
      left: theme.color('--left'),
      right: theme.color('--right'),
      middle: theme.color('--middle'),
    };
    const { color: chosen } = this.style;
    const colorOf = (point: number): string => {
      if (chosen === undefined) return sides[sideOf(this.figure.names[point] ?? '')];
      return theme.color(typeof chosen === 'string' ? chosen : chosen(point));
    };
    const color = new Color();
    this.figure.names.forEach((_, point) => {
      const text = point === this.highlighted ? theme.color('--accent') : colorOf(point);
      this.points.setColorAt(point, color.set(text));
    });
    this.figure.bones.forEach((bone, index) => {
      this.bones.setColorAt(index, color.set(colorOf(bone.toPoint)));
    });
    for (const mesh of [this.points, this.bones]) {
      if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
    }
    this.scene.invalidate();
  }
}
