import {
  BoxGeometry,
  Color,
  CylinderGeometry,
  Group,
  InstancedMesh,
  Matrix4,
  type MeshLambertMaterial,
  Quaternion,
  SphereGeometry,
  SRGBColorSpace,
  Vector3,
  type BufferGeometry,
} from 'three';
import { VisualGeometry, type LinkVisual } from '../api/messages';
import { readableOn } from '../drawing/palette';
import type { JointTrack } from '../motion/motion';
import type { Scene } from './scene';

export interface VisualStyle {
  // Name of a colour of the style sheet, for shapes without a material.
  color: string;
  // 0 to 1.
  opacity: number;
}

// Shapes of extent 1 along x, y and z.
const kUnitShapes: readonly (readonly [VisualGeometry, () => BufferGeometry])[] = [
  [VisualGeometry.BOX, () => new BoxGeometry(1, 1, 1)],
  [VisualGeometry.CYLINDER, () => new CylinderGeometry(0.5, 0.5, 1, 24).rotateX(Math.PI / 2)],
  [VisualGeometry.SPHERE, () => new SphereGeometry(0.5, 24, 16)],
];

// The visual shapes of one kind, in one draw call.
interface VisualMesh {
  mesh: InstancedMesh<BufferGeometry, MeshLambertMaterial>;
  // Of each instance: its joint, and the matrix from the unit shape to the frame of the joint.
  parts: readonly { joint: number; jointFromUnit: Matrix4; visual: LinkVisual }[];
}

// The visual shapes of a robot's links, in a draw call for each kind: boxes, cylinders, spheres. They
// have the colours of their materials, as far as these stand out from the background; all have the
// same opacity. The shapes of a joint with a missing pose are not drawn.
export class VisualObject {
  private readonly group = new Group();
  private readonly meshes: readonly VisualMesh[];
  private readonly matrix = new Matrix4();
  private readonly position = new Vector3();
  private readonly rotation = new Quaternion();
  private readonly one = new Vector3(1, 1, 1);
  private readonly forgetTheme: () => void;

  constructor(
    private readonly scene: Scene,
    visuals: readonly LinkVisual[],
    { color, opacity }: VisualStyle,
  ) {
    this.meshes = kUnitShapes.flatMap(([kind, createShape]) => {
      const ofKind = visuals.filter(({ geometry }) => geometry === kind);
      if (ofKind.length === 0) return [];
      const mesh = new InstancedMesh(createShape(), scene.surface(opacity), ofKind.length);
      mesh.frustumCulled = false;
      this.group.add(mesh);
      return [
        {
          mesh,
          parts: ofKind.map((visual) => ({
            joint: visual.joint,
            jointFromUnit: jointFromUnit(visual),
            visual,
          })),
        },
      ];
    });
    scene.root.add(this.group);
    this.forgetTheme = scene.onTheme(() => {
      const shown = new Color();
      for (const { mesh, parts } of this.meshes) {
        parts.forEach(({ visual: { color: own } }, index) => {
          const [red, green, blue] = own;
          if (red === undefined || green === undefined || blue === undefined)
            shown.set(scene.theme.color(color));
          else {
            const background = scene.theme.color('--scene');
            shown.setRGB(...readableOn(background, [red, green, blue]), SRGBColorSpace);
          }
          mesh.setColorAt(index, shown);
        });
        if (mesh.instanceColor) mesh.instanceColor.needsUpdate = true;
      }
    });
  }

  // Shows a pose. positions: joints x 3, m; rotations: joints x 4, from the joint to the world.
  update(positions: Float32Array, rotations: Float32Array): void {
    for (const { mesh, parts } of this.meshes) {
      parts.forEach(({ joint, jointFromUnit }, index) => {
        this.position.fromArray(positions, 3 * joint);
        this.rotation.fromArray(rotations, 4 * joint);
        const { x, y, z } = this.position;
        if (Number.isFinite(x + y + z + this.rotation.lengthSq()))
          this.matrix.compose(this.position, this.rotation, this.one).multiply(jointFromUnit);
        else this.matrix.makeScale(0, 0, 0);
        mesh.setMatrixAt(index, this.matrix);
      });
      mesh.instanceMatrix.needsUpdate = true;
    }
    this.scene.invalidate();
  }

  set visible(visible: boolean) {
    this.group.visible = visible;
    this.scene.invalidate();
  }

  dispose(): void {
    this.forgetTheme();
    this.scene.root.remove(this.group);
    for (const { mesh } of this.meshes) {
      mesh.geometry.dispose();
      mesh.dispose();
    }
    this.scene.invalidate();
  }
}

// The bones that are not those of links with shapes: a bone begins at the joint that moves its link.
export function bonesWithoutVisuals({ bones, visuals }: JointTrack): JointTrack['bones'] {
  const drawn = new Set(visuals.map(({ joint }) => joint));
  return bones.filter(({ fromPoint }) => !drawn.has(fromPoint));
}

function jointFromUnit({ positionM, rotation, sizeM }: LinkVisual): Matrix4 {
  return new Matrix4().compose(
    new Vector3().fromArray(positionM),
    new Quaternion().fromArray(rotation),
    new Vector3().fromArray(sizeM),
  );
}
