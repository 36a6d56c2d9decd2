import {
  Color,
  GridHelper,
  Group,
  InstancedMesh,
  Matrix4,
  MeshLambertMaterial,
  type Object3D,
  type Points,
} from 'three';
import type { PicturePlace } from '../../dom/fingers';
import type { Scene } from '../../scene/scene';
import { kEllipsoidBudget, largestNodes, strongestTransitions } from './level_of_detail';
import {
  createDots,
  createEdges,
  createEllipsoids,
  setEllipsoid,
  type Edges,
  type Ellipsoids,
} from './map_meshes';
import type { MapAppearance, MapPicture } from './map_picture';
import { pick, projectPoints, viewOf, type Axes } from './projection';
import { extentOf, type StateMap } from './state_map';

// Radius of a map in the scene.
const kRadius = 3;
const kReach = 14;
// Wait after a move of the camera before other nodes become ellipsoids, ms.
const kSettle = 120;
// Dots drawn while the camera moves.
const kMovingDots = 15_000;
// Vertical field of view in degrees: planes are seen from far away, almost in parallel projection.
export const kSpatialView = 40;
export const kPlaneView = 4;

// A map in a scene, in at most 5 draw calls: dots for all nodes and frames, ellipsoids for the
// nodes that look largest, edges by probability, and a grid of the first two axes.
export class MapObject implements MapPicture {
  readonly surface: HTMLCanvasElement;
  private readonly group = new Group();
  private readonly viewMatrix = new Matrix4();
  private readonly drawnMatrix = new Matrix4();
  private map: StateMap | undefined;
  private appearance: MapAppearance | undefined;
  private ellipsoids: Ellipsoids | undefined;
  private dots: Points | undefined;
  private axes: Axes | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly scene: Scene,
    onDrawn: () => void,
  ) {
    this.surface = scene.canvas;
    scene.root.add(this.group);
    scene.root.onAfterRender = () => {
      this.watchCamera();
      onDrawn();
    };
  }

  draw(map: StateMap, appearance: MapAppearance): void {
    this.clear();
    this.map = map;
    this.appearance = appearance;
    const { centre, radius } = extentOf(map);
    const scale = kRadius / radius;
    this.group.scale.setScalar(scale);
    this.group.position.set(...centre).multiplyScalar(-scale);
    this.group.updateMatrixWorld(true);
    const { nodes, points } = map;
    const grid = new GridHelper(2 * radius, 10, appearance.edgeColor, appearance.edgeColor);
    grid.rotateX(Math.PI / 2);
    grid.position.set(centre[0], centre[1], appearance.axes === '123' ? 0 : centre[2] - radius);
    grid.material.opacity = 0.25;
    grid.material.transparent = true;
    if (appearance.axes === '123' || appearance.axes === '12') this.group.add(grid);
    const dots = createDots(nodes.means, appearance.nodeColors, appearance.nodesShown, 5);
    this.dots = dots;
    this.ellipsoids = createEllipsoids(
      Math.min(nodes.ids.length, kEllipsoidBudget),
      this.scene.surface(0.45),
    );
    this.group.add(
      dots,
      createDots(points.positions, appearance.pointColors, appearance.pointsShown, 1.5),
      this.createTransitions(map, appearance, radius),
      this.ellipsoids,
    );
    if (this.axes !== appearance.axes) this.lookAlong(appearance.axes);
    this.updateEllipsoids();
  }

  // Looks at the whole map along its axes.
  lookAlong(axes: Axes): void {
    this.axes = axes;
    const { camera } = this.scene;
    camera.fov = axes === '123' ? kSpatialView : kPlaneView;
    camera.updateProjectionMatrix();
    const half = (camera.fov * Math.PI) / 360;
    const distance = kRadius / Math.sin(half) / Math.min(1, camera.aspect);
    const { from } = viewOf(axes);
    const step = distance / Math.hypot(...from);
    this.scene.orbit.place([from[0] * step, from[1] * step, from[2] * step], [0, 0, 0]);
  }

  nodeAt(x: number, y: number): number {
    const { map, appearance } = this;
    if (!map || !appearance) return -1;
    const node = pick(this.project(map.nodes.means), appearance.nodesShown, x, y, kReach);
    if (node >= 0) return node;
    const positions = this.project(map.points.positions);
    const point = pick(positions, appearance.pointsShown, x, y, kReach / 2);
    return point >= 0 ? map.points.nodes[point]! : -1;
  }

  placeOf(node: number): PicturePlace | undefined {
    if (!this.map) return undefined;
    const [x, y] = this.project(this.map.nodes.means.subarray(3 * node, 3 * node + 3));
    return x === undefined || y === undefined || Number.isNaN(x) ? undefined : { x, y };
  }

  dispose(): void {
    clearTimeout(this.timer);
    this.clear();
    this.scene.root.remove(this.group);
  }

  private project(positions: Float32Array): Float32Array {
    const { clientWidth, clientHeight } = this.surface;
    return projectPoints(positions, this.matrix().elements, clientWidth, clientHeight);
  }

  private matrix(): Matrix4 {
    const { camera } = this.scene;
    camera.updateMatrixWorld();
    return this.viewMatrix
      .multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse)
      .multiply(this.group.matrixWorld);
  }

  private createTransitions(map: StateMap, appearance: MapAppearance, radius: number): Object3D {
    const { from, to, probabilities } = map.transitions;
    const edges: [number, number, number][] = [];
    for (const edge of strongestTransitions(map.transitions, appearance.leastProbability)) {
      const [start, end] = [from[edge]!, to[edge]!];
      if (appearance.nodesShown[start] === 0 || appearance.nodesShown[end] === 0) continue;
      edges.push([start, end, radius * (0.0006 + 0.006 * probabilities[edge]!)]);
    }
    return createEdges(map.nodes.means, edges, appearance.edgeColor, 0.6);
  }

  // While the camera moves or is held, a large map has less detail: a picture with all of it can take
  // longer than the wait for the next move. When the camera rests, other nodes are the nearest.
  private watchCamera(): void {
    if (this.matrix().equals(this.drawnMatrix)) return;
    this.showDetail((this.map?.nodes.ids.length ?? 0) <= kMovingDots);
    this.settle();
  }

  private settle(): void {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      if (this.scene.orbit.isHeld) {
        this.settle();
        return;
      }
      this.showDetail(true);
      this.updateEllipsoids();
    }, kSettle);
  }

  // Without detail: a sample of the dots, and no ellipsoids.
  private showDetail(detail: boolean): void {
    if (this.ellipsoids) this.ellipsoids.visible = detail;
    this.dots?.geometry.setDrawRange(0, detail ? Infinity : kMovingDots);
  }

  private updateEllipsoids(): void {
    const { map, appearance, ellipsoids } = this;
    if (!map || !appearance || !ellipsoids) return;
    this.drawnMatrix.copy(this.matrix());
    const least = 1e-4 * extentOf(map).radius;
    const color = new Color();
    let place = 0;
    for (const node of largestNodes(map.nodes, this.drawnMatrix.elements)) {
      if (appearance.nodesShown[node] === 0) continue;
      setEllipsoid(ellipsoids, place, map.nodes, node, appearance.size, least);
      const [r, g, b] = appearance.nodeColors.subarray(3 * node, 3 * node + 3);
      ellipsoids.setColorAt(place++, color.setRGB(r!, g!, b!, 'srgb'));
    }
    ellipsoids.count = place;
    ellipsoids.instanceMatrix.needsUpdate = true;
    if (ellipsoids.instanceColor) ellipsoids.instanceColor.needsUpdate = true;
    this.scene.invalidate();
  }

  private clear(): void {
    this.remove([...this.group.children]);
    this.ellipsoids = undefined;
    this.dots = undefined;
  }

  private remove(objects: readonly Object3D[]): void {
    for (const object of objects) {
      const drawn = object as Ellipsoids | Edges | GridHelper;
      drawn.geometry.dispose();
      if (drawn instanceof InstancedMesh) drawn.dispose();
      // Lit surfaces share materials of the scene.
      if (!(drawn.material instanceof MeshLambertMaterial)) drawn.material.dispose();
      this.group.remove(object);
    }
  }
}
