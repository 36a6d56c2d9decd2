import {
  AmbientLight,
  Color,
  DirectionalLight,
  MeshLambertMaterial,
  PerspectiveCamera,
  Scene as ThreeScene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { Disposer } from '../dom/disposer';
import { element } from '../dom/element';
import type { ThemeSwitch } from '../shell/theme';
import { OrbitCamera } from './orbit_camera';

const kStatisticsPictures = 240;

// Work of the main thread for the last pictures.
export class FrameStatistics {
  private readonly work: number[] = [];
  private readonly intervals: number[] = [];
  drawCalls = 0;
  pictures = 0;

  // Adds a picture: milliseconds of work, seconds since the picture before (0: none), draw calls.
  add(milliseconds: number, seconds: number, drawCalls: number): void {
    ++this.pictures;
    push(this.work, milliseconds);
    if (seconds > 0) push(this.intervals, seconds);
    this.drawCalls = drawCalls;
  }

  // 95th percentile of the work, in milliseconds; 0 without pictures.
  get p95Milliseconds(): number {
    return percentile(this.work, 0.95);
  }

  // Pictures per second; 0 without an animation.
  get rateHz(): number {
    const total = this.intervals.reduce((sum, interval) => sum + interval, 0);
    return total > 0 ? this.intervals.length / total : 0;
  }
}

export function percentile(values: readonly number[], fraction: number): number {
  if (values.length === 0) return 0;
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))] ?? 0;
}

function push(values: number[], value: number): void {
  values.push(value);
  if (values.length > kStatisticsPictures) values.shift();
}

const kMaxPixelRatio = 2;

export interface SceneOptions {
  theme: ThemeSwitch;
  // What the picture shows, for screen readers.
  label: string;
}

export interface ScreenPoint {
  // Pixels of the style sheet from the left upper corner of the canvas.
  x: number;
  y: number;
}

// A picture in three dimensions: metres, z up. It renders only after `invalidate` or a move of the
// camera.
export class Scene {
  readonly root = new ThreeScene();
  readonly camera = new PerspectiveCamera(40, 1, 0.05, 500);
  readonly orbit: OrbitCamera;
  readonly statistics = new FrameStatistics();
  private readonly disposer = new Disposer();
  private readonly animations = new Set<(seconds: number) => void>();
  private readonly themed = new Set<() => void>();
  private readonly surfaces = new Map<number, MeshLambertMaterial>();
  private request = 0;
  // Something has changed since the last picture.
  private changed = true;
  private lastTime = 0;
  private lastPicture = 0;
  private width = 1;
  private height = 1;
  private readonly scratch = new Vector3();

  constructor(
    host: HTMLElement,
    readonly canvas: HTMLCanvasElement,
    private readonly renderer: WebGLRenderer,
    readonly theme: ThemeSwitch,
  ) {
    this.camera.up.set(0, 0, 1);
    this.orbit = new OrbitCamera(this.camera, canvas, () => {
      this.invalidate();
    });
    const light = new DirectionalLight(0xffffff, 1.6);
    light.position.set(2, -3, 6);
    this.root.add(new AmbientLight(0xffffff, 1.5), light);
    const observer = new ResizeObserver(() => {
      this.resize(host);
    });
    observer.observe(host);
    this.disposer.add(() => {
      observer.disconnect();
    });
    this.disposer.add(
      theme.onChange(() => {
        this.applyTheme();
      }),
    );
    this.disposer.listen(canvas, 'webglcontextrestored', () => {
      this.invalidate();
    });
    this.applyTheme();
    this.resize(host);
  }

  // Renders before the next picture of the screen.
  invalidate(): void {
    this.changed = true;
    this.requestPicture();
  }

  private requestPicture(): void {
    if (this.request === 0 && !this.disposer.disposed) {
      this.request = requestAnimationFrame((time) => {
        this.render(time);
      });
    }
  }

  // Calls back before each picture of the screen, with the time since the last one in seconds, until
  // the returned function is called.
  animate(callback: (seconds: number) => void): () => void {
    this.animations.add(callback);
    this.lastTime = 0;
    this.requestPicture();
    return () => this.animations.delete(callback);
  }

  // Where a point appears; undefined behind the camera.
  project(x: number, y: number, z: number): ScreenPoint | undefined {
    this.camera.updateMatrixWorld();
    const point = this.scratch.set(x, y, z).project(this.camera);
    if (point.z < -1 || point.z > 1 || !Number.isFinite(point.x)) return undefined;
    return { x: ((point.x + 1) / 2) * this.width, y: ((1 - point.y) / 2) * this.height };
  }

  // Calls back when the theme has changed, and once immediately, until the returned function is called.
  onTheme(callback: () => void): () => void {
    callback();
    this.themed.add(callback);
    return () => this.themed.delete(callback);
  }

  // The material of lit surfaces with an opacity, for objects with a colour for each instance. They
  // share it, because its program takes up to seconds to compile; the scene disposes it.
  surface(opacity: number): MeshLambertMaterial {
    let material = this.surfaces.get(opacity);
    if (!material) {
      const transparent = opacity < 1;
      material = new MeshLambertMaterial({ transparent, opacity, depthWrite: !transparent });
      this.surfaces.set(opacity, material);
    }
    return material;
  }

  // Releases the memory of the graphics processor. Objects in the scene are disposed by their owner.
  dispose(): void {
    this.disposer.dispose();
    cancelAnimationFrame(this.request);
    this.animations.clear();
    this.themed.clear();
    for (const material of this.surfaces.values()) material.dispose();
    this.orbit.dispose();
    this.root.clear();
    this.renderer.dispose();
    this.renderer.getContext().getExtension('WEBGL_lose_context')?.loseContext();
    this.canvas.remove();
  }

  private render(time: number): void {
    this.request = 0;
    const begin = performance.now();
    const seconds = this.lastTime === 0 ? 0 : (time - this.lastTime) / 1000;
    for (const callback of [...this.animations]) callback(seconds);
    const running = this.animations.size > 0;
    this.lastTime = running ? time : 0;
    if (this.changed) {
      this.changed = false;
      this.renderer.render(this.root, this.camera);
      const between = running && this.lastPicture > 0 ? (time - this.lastPicture) / 1000 : 0;
      this.statistics.add(performance.now() - begin, between, this.renderer.info.render.calls);
      this.lastPicture = running ? time : 0;
    }
    if (running) this.requestPicture();
  }

  private resize(host: HTMLElement): void {
    this.width = Math.max(1, host.clientWidth);
    this.height = Math.max(1, host.clientHeight);
    this.camera.aspect = this.width / this.height;
    this.camera.updateProjectionMatrix();
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, kMaxPixelRatio));
    this.renderer.setSize(this.width, this.height);
    this.invalidate();
  }

  private applyTheme(): void {
    this.root.background = new Color(this.theme.color('--scene'));
    for (const callback of this.themed) callback();
    this.invalidate();
  }
}

// A scene that fills its host; undefined, with a text in the host, if the browser has no WebGL.
export function createScene(host: HTMLElement, options: SceneOptions): Scene | undefined {
  const canvas = element('canvas', { tabindex: 0, role: 'img', 'aria-label': options.label });
  const attributes = { antialias: devicePixelRatio < 2, powerPreference: 'low-power' } as const;
  // Smooth edges cost a processor that draws alone most of its time.
  const context =
    canvas.getContext('webgl2', { ...attributes, failIfMajorPerformanceCaveat: true }) ??
    canvas.getContext('webgl2', { ...attributes, antialias: false });
  if (!context) {
    host.append(
      element(
        'p',
        { class: 'hint no-webgl' },
        'This browser has no WebGL, so there is no picture in three dimensions.',
      ),
    );
    return undefined;
  }
  host.append(canvas);
  return new Scene(host, canvas, new WebGLRenderer({ canvas, context }), options.theme);
}
