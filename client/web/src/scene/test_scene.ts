// A scene without a canvas, for unit tests of the objects in it.
import { MeshLambertMaterial, Scene as ThreeScene, type InstancedMesh } from 'three';
import type { Scene } from './scene';

export function testScene(color: (name: string) => string = () => '#808080'): {
  root: ThreeScene;
  scene: Scene;
  // Callbacks that wait for a change of the theme.
  themed: Set<() => void>;
  surface: MeshLambertMaterial;
} {
  const root = new ThreeScene();
  const theme = { color };
  const themed = new Set<() => void>();
  const surface = new MeshLambertMaterial();
  const scene = {
    root,
    theme,
    onTheme: (apply: () => void) => {
      apply();
      themed.add(apply);
      return () => themed.delete(apply);
    },
    surface: () => surface,
    invalidate: () => undefined,
  };
  return { root, scene: scene as unknown as Scene, themed, surface };
}

export function instancedMeshes(root: ThreeScene): InstancedMesh[] {
  const meshes: InstancedMesh[] = [];
  root.traverse((node) => {
    if ('isInstancedMesh' in node) meshes.push(node as InstancedMesh);
  });
  return meshes;
}
