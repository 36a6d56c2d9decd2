import { Color, Matrix4, Vector3, type CircleGeometry } from 'three';
import { expect, test } from 'vitest';
import { ContactObject, footPoints } from './contact_object';
import { instancedMeshes, testScene } from './test_scene';

const names = ['LHip', 'LAnkle', 'LToe', 'RAnkle', 'RHeel', 'Head'];
const pose = Float32Array.of(9, 9, 1, 1, 2, 0.1, 2, 3, 0, 4, -1, 0.1, 5, -2, 0, 9, 9, 2);

function openContacts() {
  const { root, scene } = testScene((name) => (name === '--left' ? '#ff0000' : '#0000ff'));
  const contacts = new ContactObject(scene, names);
  const [mesh] = instancedMeshes(root);
  // Place of the disc of each foot, 0: left; null: no disc.
  const places = () =>
    [0, 1].map((foot) => {
      const matrix = new Matrix4();
      mesh!.getMatrixAt(foot, matrix);
      const { x, y } = new Vector3().setFromMatrixPosition(matrix);
      const size = matrix.getMaxScaleOnAxis();
      return size === 0 ? null : [x, y, size];
    });
  return { contacts, mesh: mesh!, places };
}

test('a disc is below the middle of the markers of each foot that stands', () => {
  const { contacts, mesh, places } = openContacts();
  const [left, right] = [
    [1.5, 2.5, 1],
    [4.5, -1.5, 1],
  ];
  const expected = [
    [null, null],
    [left, null],
    [null, right],
    [left, right],
  ];
  expected.forEach((discs, byte) => {
    contacts.update(byte, pose);
    expect(places()).toEqual(discs);
  });
  expect((mesh.geometry as CircleGeometry).parameters.radius).toBe(0.09);
  const colors = [0, 1].map((foot) => {
    const color = new Color();
    mesh.getColorAt(foot, color);
    return color.getHexString();
  });
  expect(colors).toEqual(['ff0000', '0000ff']);
});

test('missing markers are left out', () => {
  const { contacts, places } = openContacts();
  const without = (points: number[]) =>
    pose.map((value, i) => (points.includes(Math.floor(i / 3)) ? NaN : value));
  contacts.update(3, without([2, 3, 4]));
  expect(places()).toEqual([[1, 2, 1], null]);
});

test('the markers of a foot', () => {
  expect([footPoints(names, 'left'), footPoints(names, 'right')]).toEqual([
    [1, 2],
    [3, 4],
  ]);
});
