import { afterEach, expect, test, vi } from 'vitest';
import { MapCanvas, FlatCamera } from './map_canvas';
import type { MapAppearance } from './map_picture';
import type { StateMap } from './state_map';
import { stubDrawing } from './test_map';

afterEach(() => {
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

test('a hidden node does not keep the pointer from a shown node beside it', () => {
  stubDrawing();
  const context = { scale: vi.fn(), fillRect: vi.fn() };
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(context as never);
  const host = document.createElement('div');
  Object.defineProperties(host, { clientWidth: { value: 400 }, clientHeight: { value: 400 } });
  const none = new Float32Array(0);
  const map = {
    nodes: { ids: [1, 2, 3], means: Float32Array.of(0, 0, 0, 0.01, 0, 0, 1, 1, 0) },
    points: { positions: none, nodes: [] },
    transitions: { from: [], to: [], probabilities: [] },
  };
  const appearance = {
    axes: '12',
    nodeColors: new Float32Array(9),
    pointColors: none,
    nodesShown: Uint8Array.of(1, 1, 1),
    pointsShown: new Uint8Array(0),
  };
  const picture = new MapCanvas(host, 'test', vi.fn());
  const draw = () => {
    picture.draw(map as unknown as StateMap, appearance as unknown as MapAppearance);
  };
  draw();
  const { x, y } = picture.placeOf(0)!;
  expect(picture.placeOf(1)!.x - x).toBeGreaterThan(1);
  expect(picture.nodeAt(x, y)).toBe(0);
  appearance.nodesShown[0] = 0;
  draw();
  expect(picture.nodeAt(x, y)).toBe(1);
  appearance.nodesShown[1] = 0;
  draw();
  expect(picture.nodeAt(x, y)).toBe(-1);
  picture.dispose();
});

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
