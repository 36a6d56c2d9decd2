import { Matrix4, Vector3, type InstancedMesh } from 'three';
import { expect, test, vi } from 'vitest';
import { ContactObject } from './contact_object';
import { FigureObject } from './figure_object';
import { FloorObject } from './floor_object';
import { linkRadii } from './figure_shape';
import { instancedMeshes, testScene } from './test_scene';
import { TrailObject } from './trail_object';
import { VisualObject } from './visual_object';

const bone = (fromPoint: number, toPoint: number) => ({ fromPoint, toPoint });
// A hip, a thigh of 0.4 m, a shin of 0.3 m, and a foot of 0.02 m; a sensor without bones.
const robot = {
  names: ['hip', 'knee', 'ankle', 'foot', 'sensor'],
  bones: [bone(0, 1), bone(1, 2), bone(2, 3)],
};
const pose = Float32Array.from([0, 0, 0.72, 0, 0, 0.32, 0, 0, 0.02, 0, 0, 0, 1, 1, 1]);

test('links are thicker if they are longer, within limits', () => {
  const radii = linkRadii(robot, pose);
  const expected = [0.064, 0.06, 0.02];
  radii?.bones.forEach((radius, index) => {
    expect(radius).toBeCloseTo(expected[index] ?? NaN, 5);
  });
  // A joint is as thick as its thickest link.
  expect(Array.from(radii?.points ?? [], (radius) => Number(radius.toFixed(5)))).toEqual([
    0.064, 0.064, 0.06, 0.02, 0,
  ]);
  expect(linkRadii(robot, pose.subarray(3))).toBeUndefined();
  expect(
    linkRadii(
      robot,
      pose.map((value, i) => (i === 4 ? NaN : value)),
    ),
  ).toBeUndefined();
  expect(linkRadii({ names: [], bones: [] }, new Float32Array(0))?.bones.length).toBe(0);
});

test('a robot is drawn as capsules in two draw calls', () => {
  const { root, scene } = testScene();
  const figure = new FigureObject(scene, robot, { links: true });
  figure.update(pose.map((value, i) => (i === 4 ? NaN : value)));
  figure.update(pose);
  const meshes = instancedMeshes(root);
  expect(meshes.length).toBe(2);
  const [points, bones] = meshes as [InstancedMesh, InstancedMesh];
  expect([points.count, bones.count]).toEqual([5, 3]);
  const sizeOf = (mesh: InstancedMesh, index: number) => {
    const matrix = new Matrix4();
    mesh.getMatrixAt(index, matrix);
    return new Vector3().setFromMatrixScale(matrix).toArray();
  };
  // Spheres of the same radius close a cylinder at its ends.
  const thigh = sizeOf(bones, 0);
  [0.064, 0.4, 0.064].forEach((size, axis) => {
    expect(thigh[axis]).toBeCloseTo(size, 5);
  });
  expect(sizeOf(points, 0)[0]).toBeCloseTo(0.064, 5);
  expect(sizeOf(points, 4)[0]).toBe(0);
  figure.dispose();
  expect(root.children.length).toBe(0);
});

test('objects that go leave the shared material, and nothing in the scene', () => {
  const { root, scene, themed, surface } = testScene();
  const disposed = vi.fn();
  surface.addEventListener('dispose', disposed);
  const figures = [new FigureObject(scene, robot), new FigureObject(scene, robot)];
  const others = [
    new VisualObject(scene, [], { color: '--ghost', opacity: 1 }),
    new ContactObject(scene, ['LAnkle', 'RAnkle']),
    new FloorObject(scene),
    new TrailObject(scene, { names: robot.names, bones: [], positions: pose }),
  ];
  expect(
    new Set(
      instancedMeshes(root)
        .slice(0, 4)
        .map(({ material }) => material),
    ).size,
  ).toBe(1);
  expect(themed.size).toBe(6);
  for (const each of [...figures, ...others]) each.dispose();
  expect(root.children.length).toBe(0);
  expect(themed.size).toBe(0);
  expect(disposed).not.toHaveBeenCalled();
});
