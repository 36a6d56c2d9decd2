import { PerspectiveCamera } from 'three';
import { expect, test } from 'vitest';
import type { Api } from '../../api/api';
import type { Scene } from '../../scene/scene';
import { instancedMeshes, testScene } from '../../scene/test_scene';
import { mapColors } from './map_colors';
import { loadMap } from './map_loader';
import { MapObject } from './map_object';
import { stateMapOf } from './test_map';

test('another node is emphasized without drawing the map again', async () => {
  const { root, scene } = testScene();
  const more = { canvas: document.createElement('canvas'), camera: new PerspectiveCamera() };
  const orbit = { place: () => undefined };
  const object = new MapObject(Object.assign(scene, more, { orbit }) as unknown as Scene);
  const api = { views: { readStateMap: () => stateMapOf(1, [4, 5, 6]) } } as unknown as Api;
  const request = { database: 'demo', layer: 2, clip: '', maxPoints: 0 };
  const map = await loadMap(api, request, new AbortController().signal);
  const texts = { edgeColor: '#000000', textColor: '#000000' };
  object.draw(map, {
    ...mapColors(map, 'label', [], 'light'),
    ...texts,
    axes: '123',
    leastProbability: 0,
    size: 1,
  });
  const drawn = [...root.children[0]!.children];
  const counts = () => instancedMeshes(root).map((mesh) => mesh.count);
  const before = counts();
  for (const node of [0, 1]) {
    object.emphasize({ nodes: new Map([[node, '#ff0000']]), path: [0, 1, 2] });
    expect(root.children[0]!.children.slice(0, drawn.length)).toEqual(drawn);
    // One node, and a path of two edges.
    expect(counts()).toEqual([...before, 1, 2]);
  }
  object.emphasize({ nodes: new Map(), path: [] });
  expect(root.children[0]!.children).toEqual(drawn);
});
