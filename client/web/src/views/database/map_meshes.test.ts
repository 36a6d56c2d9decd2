import { Matrix4, Vector3, MeshLambertMaterial } from 'three';
import { describe, expect, it } from 'vitest';
import { createDots, createEllipsoids, setEllipsoid, spreadOrder } from './map_meshes';
import type { MapNodes } from './state_map';

describe('spreadOrder', () => {
  it('has each index once', () => {
    for (const count of [0, 1, 2, 3, 10, 97, 1000]) {
      const order: number[] = [];
      spreadOrder(count, (i) => order.push(i));
      expect([...order].sort((a, b) => a - b)).toEqual(Array.from({ length: count }, (_, i) => i));
    }
  });

  it('begins with a sample of all places', () => {
    const order: number[] = [];
    spreadOrder(1000, (i) => order.push(i));
    const tenths = new Set(order.slice(0, 50).map((i) => Math.floor(i / 100)));
    expect(tenths.size).toBe(10);
  });
});

describe('createDots', () => {
  it('leaves out what is not shown', () => {
    const positions = Float32Array.of(0, 0, 0, 1, 1, 1, 2, 2, 2);
    const dots = createDots(positions, new Float32Array(9), Uint8Array.of(1, 0, 1), 3);
    const { array } = dots.geometry.getAttribute('position');
    expect([...array].sort()).toEqual([0, 0, 0, 2, 2, 2]);
  });
});

describe('setEllipsoid', () => {
  it('maps the unit sphere to the scaled semi-axes', () => {
    const semiAxes = Float32Array.of(0, 3, 0, 2, 0, 0, 0, 0, 1);
    const nodes = { means: Float32Array.of(5, 6, 7), semiAxes } as unknown as MapNodes;
    const mesh = createEllipsoids(1, new MeshLambertMaterial());
    setEllipsoid(mesh, 0, nodes, 0, 0.5, 0.01);
    const matrix = new Matrix4();
    mesh.getMatrixAt(0, matrix);
    const at = (x: number, y: number, z: number) =>
      new Vector3(x, y, z)
        .applyMatrix4(matrix)
        .sub(new Vector3(5, 6, 7))
        .toArray();
    expect(at(1, 0, 0)).toEqual([0, 1.5, 0]);
    expect(at(0, 1, 0)).toEqual([1, 0, 0]);
    expect(at(0, 0, 1).map(Math.abs)).toEqual([0, 0, 0.5]);
  });
});
