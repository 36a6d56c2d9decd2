import { Spherical, Vector3, type PerspectiveCamera } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { arrowOf, type Arrow } from '../dom/arrow_keys';

const kTurn = Math.PI / 36;
const kZoom = 1.1;
// Part of the distance to the target.
const kMove = 0.05;

// A camera that turns around a target by pointer, touch, wheel and keys, and can follow it.
// Keys on the canvas: arrows turn, Shift with arrows moves, + and - zoom.
export class OrbitCamera {
  private readonly controls: OrbitControls;
  private readonly onKey = (event: KeyboardEvent) => {
    this.press(event);
  };
  private readonly moved: () => void;
  private held = false;

  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly canvas: HTMLCanvasElement,
    private readonly changed: () => void,
  ) {
    this.controls = new OrbitControls(camera, canvas);
    this.controls.maxPolarAngle = Math.PI * 0.98;
    this.controls.minDistance = 0.2;
    this.controls.maxDistance = 200;
    this.moved = () => {
      changed();
    };
    this.controls.addEventListener('change', this.moved);
    this.controls.addEventListener('start', () => {
      this.held = true;
    });
    this.controls.addEventListener('end', () => {
      this.held = false;
    });
    canvas.addEventListener('keydown', this.onKey);
    this.place([3.2, -3.2, 1.8], [0, 0, 0.9]);
  }

  // True while a button or a finger holds the camera.
  get isHeld(): boolean {
    return this.held;
  }

  get target(): Vector3 {
    return this.controls.target;
  }

  place(
    position: readonly [number, number, number],
    target: readonly [number, number, number],
  ): void {
    this.camera.position.set(...position);
    this.controls.target.set(...target);
    this.controls.update();
    this.changed();
  }

  // Moves camera and target together, so that the target is at a point.
  follow(x: number, y: number, z: number): void {
    if (![x, y, z].every(Number.isFinite)) return;
    const step = new Vector3(x, y, z).sub(this.controls.target);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
  }

  // Shows its target from the same side and distance as another camera shows its own.
  copyView(other: OrbitCamera): void {
    const offset = other.camera.position.clone().sub(other.controls.target);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.changed();
  }

  // Calls back when the camera has moved. Returns the function that removes the listener.
  onMove(listener: () => void): () => void {
    this.controls.addEventListener('change', listener);
    return () => {
      this.controls.removeEventListener('change', listener);
    };
  }

  // Calls back after each move by the user.
  onEnd(callback: () => void): void {
    this.controls.addEventListener('end', callback);
  }

  // Six numbers, position then target, for a URL.
  get state(): string {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()]
      .map((v) => v.toFixed(2))
      .join(',');
  }

  // Restores what `state` gave. Returns false, and changes nothing, for any other text.
  restore(state: string | null): boolean {
    const [px, py, pz, tx, ty, tz, ...rest] = (state ?? '').split(',').map(Number);
    const values = [px, py, pz, tx, ty, tz];
    if (
      state === null ||
      rest.length > 0 ||
      !values.every((value) => value !== undefined && Number.isFinite(value))
    )
      return false;
    this.place([px ?? 0, py ?? 0, pz ?? 0], [tx ?? 0, ty ?? 0, tz ?? 0]);
    return true;
  }

  dispose(): void {
    this.controls.removeEventListener('change', this.moved);
    this.canvas.removeEventListener('keydown', this.onKey);
    this.controls.dispose();
  }

  // Moves camera and target in the plane of the picture.
  private moveBy({ right, up }: Arrow, length: number): void {
    const axis = right !== 0 ? 0 : 1;
    const step = new Vector3().setFromMatrixColumn(this.camera.matrix, axis);
    step.multiplyScalar((right + up) * length);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    this.controls.dispatchEvent({ type: 'end' });
  }

  private press(event: KeyboardEvent): void {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const offset = this.camera.position.clone().sub(this.controls.target);
    const arrow = arrowOf(event.key);
    if (arrow && event.shiftKey) {
      event.preventDefault();
      event.stopPropagation();
      this.moveBy(arrow, kMove * offset.length());
      return;
    }
    // Spherical has y up.
    const spherical = new Spherical().setFromVector3(new Vector3(offset.x, offset.z, -offset.y));
    if (arrow) {
      spherical.theta += arrow.right * kTurn;
      const phi = spherical.phi - arrow.up * kTurn;
      if (arrow.up !== 0) spherical.phi = Math.min(Math.PI * 0.98, Math.max(0.05, phi));
    } else if (event.key === '+' || event.key === '=')
      spherical.radius = Math.max(0.2, spherical.radius / kZoom);
    else if (event.key === '-') spherical.radius = Math.min(200, spherical.radius * kZoom);
    else return;
    event.preventDefault();
    event.stopPropagation();
    const turned = new Vector3().setFromSpherical(spherical);
    this.camera.position.set(turned.x, -turned.z, turned.y).add(this.controls.target);
    this.controls.update();
    this.controls.dispatchEvent({ type: 'end' });
  }
}
