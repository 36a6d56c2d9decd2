import { create } from '@bufbuild/protobuf';
import { Color, Vector3, type InstancedMesh } from 'three';
import { expect, test } from 'vitest';
import { FigureSchema, LinkVisualSchema, VisualGeometry, type LinkVisual } from '../api/messages';
import {
  floatBytes,
  copyFrames,
  copyRotations,
  createMotion,
  frameOf,
  rotationsOf,
} from '../motion/motion';
import { instancedMeshes, testScene } from './test_scene';
import { bonesWithoutVisuals, VisualObject } from './visual_object';

const style = { color: '--ghost', opacity: 0.5 };
const quarter = Math.SQRT1_2;

function visualOf(
  joint: number,
  geometry: VisualGeometry,
  sizeM: number[],
  positionM = [0, 0, 0],
  rotation = [0, 0, 0, 1],
): LinkVisual {
  return create(LinkVisualSchema, { joint, geometry, sizeM, positionM, rotation });
}

// The corners of an instance in the world, in mm, without repetitions.
function cornersOf(mesh: InstancedMesh, index: number): Set<string> {
  const matrix = mesh.matrixWorld.clone();
  mesh.getMatrixAt(index, matrix);
  const { count } = mesh.geometry.attributes.position!;
  const corners = new Set<string>();
  for (let vertex = 0; vertex < count; ++vertex) {
    const at = new Vector3()
      .fromBufferAttribute(mesh.geometry.attributes.position!, vertex)
      .applyMatrix4(matrix);
    corners.add(at.toArray().map(millimetres).join(' '));
  }
  return corners;
}

const millimetres = (metres: number) => Math.round(1000 * metres) + 0;

// Smallest and largest x, y and z of an instance, in mm.
function extentOf(mesh: InstancedMesh, index: number): number[][] {
  const corners = [...cornersOf(mesh, index)].map((text) => text.split(' ').map(Number));
  return [0, 1, 2].map((axis) => {
    const values = corners.map((corner) => corner[axis] ?? NaN);
    return [Math.min(...values), Math.max(...values)];
  });
}

test('a box is where its joint and its origin place it', () => {
  const { root, scene } = testScene();
  // Turned by 90 degrees about x in the frame of joint 1, which is turned by 90 degrees about z.
  const box = visualOf(
    1,
    VisualGeometry.BOX,
    [0.2, 0.4, 0.6],
    [0.1, 0, 0.05],
    [quarter, 0, 0, quarter],
  );
  const visuals = new VisualObject(scene, [box], style);
  const positions = Float32Array.from([9, 9, 9, 1, 2, 3]);
  const rotations = Float32Array.from([0, 0, 0, 1, 0, 0, quarter, quarter]);
  visuals.update(positions, rotations);
  const expected = new Set<string>();
  for (const x of [-0.1, 0.1])
    for (const y of [-0.2, 0.2])
      for (const z of [-0.3, 0.3]) {
        // About x: y becomes z, and z becomes -y. Then the origin.
        const [linkX, linkY, linkZ] = [0.1 + x, -z, 0.05 + y];
        // About z: x becomes y, and y becomes -x. Then the position of the joint.
        expected.add([1 - linkY, 2 + linkX, 3 + linkZ].map(millimetres).join(' '));
      }
  const [mesh] = instancedMeshes(root);
  expect(cornersOf(mesh!, 0)).toEqual(expected);
  expect(expected.size).toBe(8);
});

test('cylinders and spheres have their extents; there is a draw call for each kind', () => {
  const { root, scene } = testScene();
  const visuals = new VisualObject(
    scene,
    [
      visualOf(0, VisualGeometry.CYLINDER, [0.2, 0.2, 1]),
      visualOf(0, VisualGeometry.SPHERE, [0.4, 0.4, 0.4], [0, 0, 1]),
      // Along x: about y, z becomes x.
      visualOf(0, VisualGeometry.CYLINDER, [0.2, 0.2, 1], [0, 0, 0], [0, quarter, 0, quarter]),
      visualOf(0, VisualGeometry.BOX, [1, 1, 1]),
      visualOf(0, VisualGeometry.UNSPECIFIED, [1, 1, 1]),
    ],
    style,
  );
  visuals.update(Float32Array.from([0, 0, 0]), Float32Array.from([0, 0, 0, 1]));
  const meshes = instancedMeshes(root);
  expect(meshes.map(({ count }) => count)).toEqual([1, 2, 1]);
  const [, cylinders, spheres] = meshes as [InstancedMesh, InstancedMesh, InstancedMesh];
  expect(extentOf(cylinders, 0)).toEqual([
    [-100, 100],
    [-100, 100],
    [-500, 500],
  ]);
  expect(extentOf(cylinders, 1)).toEqual([
    [-500, 500],
    [-100, 100],
    [-100, 100],
  ]);
  expect(extentOf(spheres, 0)).toEqual([
    [-200, 200],
    [-200, 200],
    [800, 1200],
  ]);
  visuals.visible = false;
  expect(root.children[0]?.visible).toBe(false);
  visuals.dispose();
  expect(root.children.length).toBe(0);
});

test('shapes have the colours of their materials, in the same draw call', () => {
  const { root, scene } = testScene();
  const [plain, dark, light] = [[], [0.2, 0, 0, 1], [1, 1, 0.9, 0.1]].map((color) => ({
    ...visualOf(0, VisualGeometry.BOX, [1, 1, 1]),
    color,
  })) as [LinkVisual, LinkVisual, LinkVisual];
  new VisualObject(scene, [plain, dark, light], style);
  const meshes = instancedMeshes(root);
  expect(meshes.length).toBe(1);
  const shown = new Color();
  const colorOf = (index: number) => {
    meshes[0]!.getColorAt(index, shown);
    return shown.getHexString();
  };
  // The colour of the style sheet, and the nearest that stand out from it: it is the background too.
  expect(colorOf(0)).toBe('808080');
  expect(colorOf(1)).toBe('330000');
  expect(new Color(`#${colorOf(2)}`).r).toBeLessThan(0.05);
});

test('a joint without a pose has no shapes', () => {
  const { root, scene } = testScene();
  const visuals = new VisualObject(scene, [visualOf(0, VisualGeometry.BOX, [1, 1, 1])], style);
  const [mesh] = instancedMeshes(root);
  const nothing = new Set(['0 0 0']);
  visuals.update(new Float32Array(0), new Float32Array(0));
  expect(cornersOf(mesh!, 0)).toEqual(nothing);
  visuals.update(Float32Array.from([0, 0, 1]), Float32Array.from([NaN, 0, 0, 1]));
  expect(cornersOf(mesh!, 0)).toEqual(nothing);
  visuals.update(Float32Array.from([0, 0, 1]), Float32Array.from([0, 0, 0, 1]));
  expect(cornersOf(mesh!, 0).size).toBe(8);
});

test('a motion keeps rotations only if there are shapes, which replace capsules', () => {
  const bone = (fromPoint: number, toPoint: number) => ({ fromPoint, toPoint });
  const figureWith = (jointVisuals: LinkVisual[]) =>
    create(FigureSchema, {
      jointNames: ['hip', 'knee', 'foot'],
      jointBones: [bone(0, 1), bone(1, 2)],
      jointVisuals,
    });
  const plain = createMotion('m', figureWith([]), 60, 2, false, true);
  expect(plain.joints.rotations.length).toBe(0);
  expect(bonesWithoutVisuals(plain.joints).length).toBe(2);
  const shape = visualOf(1, VisualGeometry.SPHERE, [1, 1, 1]);
  const { joints } = createMotion('m', figureWith([shape]), 60, 2, false, true);
  expect(bonesWithoutVisuals(joints)).toEqual([expect.objectContaining(bone(0, 1))]);
  const values = Float32Array.from({ length: 12 }, (_, index) => index);
  copyRotations(joints, 1, floatBytes(values));
  copyFrames(joints, 1, floatBytes(values.subarray(0, 9)));
  expect([...rotationsOf(joints, 1)]).toEqual([...values]);
  expect([...frameOf(joints, 1)]).toEqual([...values.subarray(0, 9)]);
  expect([...rotationsOf(joints, 0)].every(Number.isNaN)).toBe(true);
});
