import { OrthographicCamera, Matrix4, PerspectiveCamera, Vector3 } from 'three';
import { describe, expect, it } from 'vitest';
import { kAllAxes, parallelMatrix, pick, projectPoints, viewOf } from './projection';

function randomPoints(count: number): Float32Array {
  let seed = 1;
  return Float32Array.from({ length: 3 * count }, () => {
    seed = (seed * 16807) % 2147483647;
    return (seed / 2147483647 - 0.5) * 8;
  });
}

describe('projectPoints', () => {
  it('agrees with the camera of three.js', () => {
    const camera = new PerspectiveCamera(50, 2, 0.1, 100);
    camera.position.set(3, -12, 4);
    camera.up.set(0, 0, 1);
    camera.lookAt(0, 0, 0);
    camera.updateMatrixWorld();
    const matrix = new Matrix4().multiplyMatrices(
      camera.projectionMatrix,
      camera.matrixWorldInverse,
    );
    const points = randomPoints(50);
    const screen = projectPoints(points, matrix.elements, 800, 400);
    for (let i = 0; i < 50; ++i) {
      const expected = new Vector3().fromArray(points, 3 * i).project(camera);
      expect(screen[3 * i]).toBeCloseTo(((expected.x + 1) / 2) * 800, 2);
      expect(screen[3 * i + 1]).toBeCloseTo(((1 - expected.y) / 2) * 400, 2);
      expect(screen[3 * i + 2]).toBeCloseTo(expected.z, 4);
    }
  });

  it('marks points behind the camera', () => {
    const behind = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -1, 0, 0, 0, 0];
    expect(projectPoints(Float32Array.of(0, 0, 5), behind, 10, 10)[0]).toBeNaN();
  });
});

describe.each(kAllAxes)('parallelMatrix for axes %s', (axes) => {
  it('agrees with an orthographic camera of three.js', () => {
    const [width, height, radius] = [600, 300, 5];
    const centre = [1, -2, 0.5];
    const view = viewOf(axes);
    const camera = new OrthographicCamera(
      -2 * radius,
      2 * radius,
      radius,
      -radius,
      -radius,
      radius,
    );
    camera.up.set(...view.up);
    const target = new Vector3(...(centre as [number, number, number]));
    camera.lookAt(new Vector3(...view.from).negate());
    camera.position.copy(target);
    camera.updateMatrixWorld();
    const expected = new Matrix4().multiplyMatrices(
      camera.projectionMatrix,
      camera.matrixWorldInverse,
    );
    const points = randomPoints(20);
    const here = projectPoints(
      points,
      parallelMatrix(axes, centre, radius, width, height),
      width,
      height,
    );
    const there = projectPoints(points, expected.elements, width, height);
    here.forEach((value, i) => {
      expect(value).toBeCloseTo(there[i]!, 2);
    });
  });
});

describe('pick', () => {
  it('finds the nearest point within reach, in front of others', () => {
    const screen = Float32Array.of(10, 10, 0.5, 10, 10, 0.2, 40, 40, 0, NaN, NaN, NaN);
    const all = Uint8Array.of(1, 1, 1, 1);
    expect(pick(screen, all, 11, 10, 5)).toBe(1);
    expect(pick(screen, all, 38, 41, 5)).toBe(2);
    expect(pick(screen, all, 25, 25, 5)).toBe(-1);
  });

  it('finds a shown point behind or beside a nearer one that is hidden', () => {
    const screen = Float32Array.of(10, 10, 0.2, 10, 10, 0.5, 13, 10, 0);
    expect(pick(screen, Uint8Array.of(0, 1, 1), 10, 10, 5)).toBe(1);
    expect(pick(screen, Uint8Array.of(0, 0, 1), 10, 10, 5)).toBe(2);
    expect(pick(screen, Uint8Array.of(0, 0, 0), 10, 10, 5)).toBe(-1);
  });
});
