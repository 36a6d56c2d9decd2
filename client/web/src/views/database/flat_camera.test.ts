import { expect, test } from 'vitest';
import { FlatCamera } from './flat_camera';

test('one pointer moves the picture', () => {
  const camera = new FlatCamera();
  expect(camera.move(1, { x: 9, y: 9 })).toBe(false);
  camera.down(1, { x: 0, y: 0 });
  expect(camera.move(1, { x: 3, y: -8 })).toBe(true);
  expect(camera.pan).toEqual({ x: 3, y: -8 });
  expect(camera.zoom).toBe(1);
  expect(camera.dragged).toBe(true);
  camera.up(1);
  expect(camera.move(1, { x: 9, y: 9 })).toBe(false);
  camera.down(1, { x: 0, y: 0 });
  expect(camera.dragged).toBe(false);
});

test('two pointers zoom, and the points below them stay there', () => {
  const camera = new FlatCamera();
  camera.down(1, { x: -10, y: 0 });
  camera.down(2, { x: 10, y: 0 });
  camera.move(2, { x: 30, y: 0 });
  expect(camera.zoom).toBeCloseTo(2);
  // A point of the picture at p is drawn at pan + zoom * p.
  expect(camera.pan.x + camera.zoom * -10).toBeCloseTo(-10);
  expect(camera.pan.x + camera.zoom * 10).toBeCloseTo(30);
});

test('the zoom is bounded and keeps its place', () => {
  const camera = new FlatCamera();
  camera.zoomAt(1000, { x: 10, y: 0 });
  expect(camera.zoom).toBe(50);
  expect(camera.pan.x + 50 * 10).toBeCloseTo(10);
});
