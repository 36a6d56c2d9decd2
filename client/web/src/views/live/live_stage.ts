import type { Figure, WatchStreamResponse } from '../../api/messages';
import { element } from '../../dom/element';
import { floatsOf } from '../../motion/motion';
import { FigureObject } from '../../scene/figure_object';
import { FloorObject } from '../../scene/floor_object';
import { createScene, type Scene } from '../../scene/scene';
import type { ThemeSwitch } from '../../shell/theme';
import { centerOf } from '../../stage/motion_stage';

const kMaxGhosts = 4;

// The figure of a stream and its predicted poses.
export class LiveStage {
  readonly node = element('div', { class: 'scene live-scene' });
  private readonly scene: Scene | undefined;
  private readonly floor: FloorObject | undefined;
  private readonly body: FigureObject | undefined;
  private readonly ghosts: FigureObject[] = [];
  private following = true;
  private placed = false;

  constructor(
    theme: ThemeSwitch,
    private readonly figure: Figure,
  ) {
    this.scene = createScene(this.node, {
      theme,
      label: 'Observed figure with its predicted poses',
    });
    if (!this.scene) return;
    this.floor = new FloorObject(this.scene);
    this.body = new FigureObject(this.scene, {
      names: figure.markerNames,
      bones: figure.markerBones,
    });
  }

  set follow(following: boolean) {
    this.following = following;
  }

  show(response: WatchStreamResponse): void {
    const { scene, body } = this;
    if (!scene || !body) return;
    const positions = floatsOf(response.markerPositions);
    body.update(positions);
    this.showGhosts(response);
    const center = centerOf(positions);
    if (!center) return;
    const [x, y] = center;
    if (!this.placed) scene.orbit.place([x + 2.6, y - 2.9, 1.7], [x, y, 0.9]);
    else if (this.following) scene.orbit.follow(x, y, scene.orbit.target.z);
    if (!this.placed || Math.hypot(x - this.floorX, y - this.floorY) > 2) this.moveFloor(x, y);
    this.placed = true;
  }

  dispose(): void {
    this.floor?.dispose();
    this.body?.dispose();
    for (const ghost of this.ghosts) ghost.dispose();
    this.scene?.dispose();
    this.node.remove();
  }

  private floorX = 0;
  private floorY = 0;

  private moveFloor(x: number, y: number): void {
    this.floorX = x;
    this.floorY = y;
    this.floor?.cover({ minX: x - 4, minY: y - 4, maxX: x + 4, maxY: y + 4 });
  }

  private showGhosts(response: WatchStreamResponse): void {
    const horizons = (response.answer?.horizons ?? []).slice(0, kMaxGhosts);
    for (const [index, horizon] of horizons.entries()) {
      this.ghost(index)?.update(floatsOf(horizon.markerPositions));
    }
    this.ghosts.forEach((ghost, index) => {
      ghost.visible = index < horizons.length;
    });
  }

  private ghost(index: number): FigureObject | undefined {
    const existing = this.ghosts[index];
    if (existing || !this.scene) return existing;
    const { markerNames, markerBones } = this.figure;
    const ghost = new FigureObject(
      this.scene,
      { names: markerNames, bones: markerBones },
      { color: '--ghost', opacity: 0.45, pointRadius: 0.014 },
    );
    this.ghosts.push(ghost);
    return ghost;
  }
}
