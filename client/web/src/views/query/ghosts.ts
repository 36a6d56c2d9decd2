import { FigureObject, type FigurePoints } from '../../scene/figure_object';
import type { Scene } from '../../scene/scene';
import type { ComparedPose } from './prediction';

// Predicted poses as ghosts, and the poses that then followed, in a scene: two draw calls a pose.
export class Ghosts {
  private figures: FigureObject[] = [];

  constructor(private readonly scene: Scene | undefined) {}

  show(figure: FigurePoints, poses: readonly ComparedPose[]): void {
    this.clear();
    if (!this.scene) return;
    for (const [i, pose] of poses.entries()) {
      const opacity = 0.75 - (0.5 * i) / Math.max(1, poses.length);
      this.add(figure, pose.predicted, '--ghost', opacity);
      if (pose.observed) this.add(figure, pose.observed, '--trail', 0.6 * opacity);
    }
  }

  clear(): void {
    for (const figure of this.figures) figure.dispose();
    this.figures = [];
  }

  private add(figure: FigurePoints, pose: Float32Array, color: string, opacity: number): void {
    if (!this.scene) return;
    const object = new FigureObject(this.scene, figure, { color, opacity, pointRadius: 0.016 });
    object.update(pose);
    this.figures.push(object);
  }
}
