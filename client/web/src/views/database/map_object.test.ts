import { PerspectiveCamera, type Points } from 'three';
import { afterEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import type { Scene } from '../../scene/scene';
import { instancedMeshes, testScene } from '../../scene/test_scene';
import { mapColors } from './map_colors';
import { loadMap } from './state_map';
import { MapObject } from './map_object';
import { stateMapOf } from './test_map';

afterEach(() => {
  vi.useRealTimers();
});

test('a large map that is held has less detail, however long its pictures take', async () => {
  const nodes = Array.from({ length: 20_000 }, (_, i) => i + 1);
  const api = { views: { readStateMap: () => stateMapOf(1, nodes) } } as unknown as Api;
  const request = { database: 'demo', layer: 2, clip: '', maxPoints: 0 };
  const map = await loadMap(api, request, new AbortController().signal);
  vi.useFakeTimers();
  const { root, scene } = testScene();
  const camera = new PerspectiveCamera();
  const orbit = { place: () => undefined, isHeld: false };
  const canvas = document.createElement('canvas');
  const object = new MapObject(
    Object.assign(scene, { camera, canvas, orbit }) as unknown as Scene,
    () => undefined,
  );
  object.draw(map, {
    ...mapColors(map, 'label', [], 'light'),
    edgeColor: '#000000',
    axes: '123',
    leastProbability: 0,
    size: 1,
  });
  // Meshes, of edges and ellipsoids, and dots.
  const detail = () => {
    let dots = Infinity;
    root.traverse((node) => {
      if ('isPoints' in node) dots = Math.min(dots, (node as Points).geometry.drawRange.count);
    });
    return [instancedMeshes(root).filter((mesh) => mesh.visible).length, dots];
  };
  // A picture of a camera that has moved.
  const move = () => {
    camera.position.x += 1;
    root.onAfterRender(...([] as unknown as Parameters<typeof root.onAfterRender>));
  };
  expect(detail()).toEqual([2, Infinity]);
  orbit.isHeld = true;
  for (let i = 0; i < 3; ++i) {
    move();
    vi.advanceTimersByTime(500);
    expect(detail()).toEqual([1, 15_000]);
  }
  orbit.isHeld = false;
  vi.advanceTimersByTime(500);
  expect(detail()).toEqual([2, Infinity]);
  object.dispose();
});
