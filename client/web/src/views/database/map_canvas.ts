import { arrowOf } from '../../dom/arrow_keys';
import { element } from '../../dom/element';
import { Fingers, type PicturePlace } from '../../dom/fingers';
import { strongestTransitions } from './level_of_detail';
import type { MapAppearance, MapPicture } from './map_picture';
import { parallelMatrix, pick, projectPoints } from './projection';
import { extentOf, type StateMap } from './state_map';

// Zoom and movement of a flat picture, changed by fingers, mouse and keys.
export class FlatCamera {
  zoom = 1;
  // Movement of the picture to the right and down, px.
  pan: PicturePlace = { x: 0, y: 0 };
  private readonly fingers = new Fingers();
  private travelled = 0;

  // Zooms so that a place, px from the middle, stays where it is.
  zoomAt(factor: number, at: PicturePlace): void {
    const zoom = Math.min(50, Math.max(0.2, this.zoom * factor));
    const real = zoom / this.zoom;
    this.pan = { x: at.x - (at.x - this.pan.x) * real, y: at.y - (at.y - this.pan.y) * real };
    this.zoom = zoom;
  }

  moveBy(x: number, y: number): void {
    this.pan = { x: this.pan.x + x, y: this.pan.y + y };
  }

  // Whether the pointers have moved the picture since the first one was put down.
  get dragged(): boolean {
    return this.travelled > 4;
  }

  // Places of pointers are px from the middle.
  down(pointer: number, at: PicturePlace): void {
    if (this.fingers.count === 0) this.travelled = 0;
    this.fingers.down(pointer, at);
  }

  // One pointer moves the picture, two also zoom it. Returns whether it has changed.
  move(pointer: number, at: PicturePlace): boolean {
    const move = this.fingers.move(pointer, at);
    if (!move) return false;
    this.travelled += Math.hypot(move.x, move.y) * this.fingers.count;
    this.moveBy(move.x, move.y);
    this.zoomAt(move.factor, move.middle);
    return true;
  }

  up(pointer: number): void {
    this.fingers.up(pointer);
  }
}

const kFlatEdges = 2000;
const kReach = 14;
const kKeyStep = 30; // px

// A map without WebGL: a parallel projection of points, nodes and edges. Drag, fingers and arrow keys
// move it; the wheel, two fingers, and the keys + and - zoom.
export class MapCanvas implements MapPicture {
  readonly surface: HTMLCanvasElement;
  private map: StateMap | undefined;
  private appearance: MapAppearance | undefined;
  private projected: Float32Array = new Float32Array(0);
  private readonly camera = new FlatCamera();
  private readonly observer: ResizeObserver;

  constructor(
    private readonly host: HTMLElement,
    label: string,
    private readonly onDrawn: () => void,
  ) {
    this.surface = element('canvas', { tabindex: 0, role: 'img', 'aria-label': label });
    host.append(this.surface);
    this.surface.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoomBy(Math.exp(-event.deltaY / 500), this.offsetOf(event));
    });
    this.surface.addEventListener('keydown', (event) => {
      this.press(event);
    });
    this.listenToPointers();
    this.observer = new ResizeObserver(() => {
      this.redraw();
    });
    this.observer.observe(host);
  }

  draw(map: StateMap, appearance: MapAppearance): void {
    this.map = map;
    this.appearance = appearance;
    this.redraw();
  }

  nodeAt(x: number, y: number): number {
    return this.appearance ? pick(this.projected, this.appearance.nodesShown, x, y, kReach) : -1;
  }

  placeOf(node: number): PicturePlace | undefined {
    const x = this.projected[3 * node];
    const y = this.projected[3 * node + 1];
    return x === undefined || y === undefined || Number.isNaN(x) ? undefined : { x, y };
  }

  dispose(): void {
    this.observer.disconnect();
    this.surface.remove();
  }

  private zoomBy(factor: number, at: PicturePlace = { x: 0, y: 0 }): void {
    this.camera.zoomAt(factor, at);
    this.redraw();
  }

  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const arrow = arrowOf(event.key);
    if (arrow) {
      event.preventDefault();
      this.camera.moveBy(-arrow.right * kKeyStep, arrow.up * kKeyStep);
      this.redraw();
    } else if (event.key === '+' || event.key === '=') {
      this.zoomBy(1.2);
    } else if (event.key === '-') {
      this.zoomBy(1 / 1.2);
    }
  }

  private listenToPointers(): void {
    const { surface, camera } = this;
    surface.addEventListener('pointerdown', (event) => {
      if (event.button !== 0) return;
      surface.setPointerCapture(event.pointerId);
      camera.down(event.pointerId, this.offsetOf(event));
    });
    surface.addEventListener('pointermove', (event) => {
      if (camera.move(event.pointerId, this.offsetOf(event))) this.redraw();
    });
    for (const type of ['pointerup', 'pointercancel'] as const)
      surface.addEventListener(type, (event) => {
        camera.up(event.pointerId);
      });
    // The end of a drag chooses no node.
    surface.addEventListener('click', (event) => {
      if (camera.dragged) event.stopImmediatePropagation();
    });
  }

  // Px from the middle of the picture.
  private offsetOf(event: MouseEvent): PicturePlace {
    const box = this.surface.getBoundingClientRect();
    return {
      x: event.clientX - box.left - box.width / 2,
      y: event.clientY - box.top - box.height / 2,
    };
  }

  private redraw(): void {
    const { map, appearance } = this;
    const context = this.surface.getContext('2d');
    if (!map || !appearance || !context) return;
    const width = Math.max(1, this.host.clientWidth);
    const height = Math.max(1, this.host.clientHeight);
    this.surface.width = width * devicePixelRatio;
    this.surface.height = height * devicePixelRatio;
    context.scale(devicePixelRatio, devicePixelRatio);
    const { centre, radius } = extentOf(map);
    const { zoom, pan } = this.camera;
    const matrix = parallelMatrix(appearance.axes, centre, radius, width, height, zoom);
    matrix[12]! += (2 * pan.x) / width;
    matrix[13]! -= (2 * pan.y) / height;
    this.projected = projectPoints(map.nodes.means, matrix, width, height);
    const points = projectPoints(map.points.positions, matrix, width, height);
    drawDots(context, points, appearance.pointsShown, appearance.pointColors, 1.5);
    this.drawEdges(context, map, appearance);
    drawDots(context, this.projected, appearance.nodesShown, appearance.nodeColors, 5);
    this.onDrawn();
  }

  private drawEdges(
    context: CanvasRenderingContext2D,
    { transitions }: StateMap,
    { nodesShown, leastProbability, edgeColor }: MapAppearance,
  ): void {
    context.strokeStyle = edgeColor;
    for (const edge of strongestTransitions(transitions, leastProbability, kFlatEdges)) {
      const from = transitions.from[edge]!;
      const to = transitions.to[edge]!;
      if (nodesShown[from] === 0 || nodesShown[to] === 0) continue;
      context.lineWidth = 0.4 + 3 * transitions.probabilities[edge]!;
      context.beginPath();
      context.moveTo(this.projected[3 * from]!, this.projected[3 * from + 1]!);
      context.lineTo(this.projected[3 * to]!, this.projected[3 * to + 1]!);
      context.stroke();
    }
  }
}

function drawDots(
  context: CanvasRenderingContext2D,
  projected: Float32Array,
  shown: Uint8Array,
  colors: Float32Array,
  size: number,
): void {
  shown.forEach((isShown, i) => {
    if (isShown === 0) return;
    const [r, g, b] = [0, 1, 2].map((k) => Math.round(255 * colors[3 * i + k]!));
    context.fillStyle = `rgb(${r ?? 0} ${g ?? 0} ${b ?? 0})`;
    context.fillRect(projected[3 * i]! - size / 2, projected[3 * i + 1]! - size / 2, size, size);
  });
}
