import { CircleGeometry, Color, InstancedMesh, Matrix4, MeshBasicMaterial } from 'three';
import { sideOf, type BodySide } from './figure_shape';
import type { Scene } from './scene';

const kRadiusM = 0.09;
const kHeightM = 0.004;

// Discs on the floor below the feet that stand, in one draw call.
export class ContactObject {
  private readonly mesh = new InstancedMesh(
    new CircleGeometry(kRadiusM, 20),
    new MeshBasicMaterial({ transparent: true, opacity: 0.55, depthWrite: false }),
    2,
  );
  private readonly feet: readonly (readonly number[])[];
  private readonly matrix = new Matrix4();
  private readonly forgetTheme: () => void;

  constructor(
    private readonly scene: Scene,
    markerNames: readonly string[],
  ) {
    this.feet = [footPoints(markerNames, 'left'), footPoints(markerNames, 'right')];
    this.mesh.frustumCulled = false;
    scene.root.add(this.mesh);
    this.forgetTheme = scene.onTheme(() => {
      this.mesh.setColorAt(0, new Color(scene.theme.color('--left')));
      this.mesh.setColorAt(1, new Color(scene.theme.color('--right')));
      if (this.mesh.instanceColor) this.mesh.instanceColor.needsUpdate = true;
    });
  }

  // Shows the feet in a byte of ReadClipMotionResponse.contacts at marker positions.
  update(contacts: number, positions: Float32Array): void {
    this.feet.forEach((points, foot) => {
      const at = (contacts & (1 << foot)) === 0 ? undefined : middleOf(points, positions);
      if (at) this.matrix.makeTranslation(at[0], at[1], kHeightM);
      else this.matrix.makeScale(0, 0, 0);
      this.mesh.setMatrixAt(foot, this.matrix);
    });
    this.mesh.instanceMatrix.needsUpdate = true;
    this.scene.invalidate();
  }

  set visible(visible: boolean) {
    this.mesh.visible = visible;
    this.scene.invalidate();
  }

  dispose(): void {
    this.forgetTheme();
    this.scene.root.remove(this.mesh);
    this.mesh.geometry.dispose();
    this.mesh.material.dispose();
    this.mesh.dispose();
  }
}

// Indices of the markers of a foot.
export function footPoints(names: readonly string[], side: BodySide): number[] {
  return names.flatMap((name, point) =>
    sideOf(name) === side && /ankle|heel|toe|foot|ball/i.test(name) ? [point] : [],
  );
}

function middleOf(
  points: readonly number[],
  positions: Float32Array,
): [number, number] | undefined {
  let x = 0;
  let y = 0;
  let count = 0;
  for (const point of points) {
    const px = positions[3 * point] ?? NaN;
    const py = positions[3 * point + 1] ?? NaN;
    if (Number.isNaN(px) || Number.isNaN(py)) continue;
    x += px;
    y += py;
    ++count;
  }
  return count === 0 ? undefined : [x / count, y / count];
}
