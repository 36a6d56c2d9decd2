// A scene without a canvas, for unit tests of the objects in it.
import { Scene as ThreeScene, type InstancedMesh } from 'three';
import type { Scene } from './scene';

export function testScene(color: (name: string) => string = () => '#808080'): {
  root: ThreeScene;
  scene: Scene;
} {
  const root = new ThreeScene();
  const theme = { color };
  const scene = {
    root,
    theme,
    onTheme: (apply: () => void) => {
      apply();
    },
    invalidate: () => undefined,
  };
  return { root, scene: scene as unknown as Scene };
}

export function instancedMeshes(root: ThreeScene): InstancedMesh[] {
  const meshes: InstancedMesh[] = [];
  root.traverse((node) => {
    if ('isInstancedMesh' in node) meshes.push(node as InstancedMesh);
  });
  return meshes;
}
