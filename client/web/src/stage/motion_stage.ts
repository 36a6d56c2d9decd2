import { element, labelled } from '../dom/element';
import { frameAt, frameOf, rotationsOf, type Motion } from '../motion/motion';
import { ContactObject } from '../scene/contact_object';
import { FigureObject } from '../scene/figure_object';
import { extentOf, FloorObject } from '../scene/floor_object';
import { createScene, type Scene } from '../scene/scene';
import { TrailObject } from '../scene/trail_object';
import { bonesWithoutVisuals, VisualObject } from '../scene/visual_object';
import type { ThemeSwitch } from '../shell/theme';

// What a stage draws besides the floor.
export type StagePart = 'markers' | 'joints' | 'contacts' | 'trails' | 'follow';
export const kStageParts: readonly StagePart[] = [
  'markers',
  'joints',
  'contacts',
  'trails',
  'follow',
];

const kTrailSeconds = 1;

// The picture of a motion at a time: figure, recorded skeleton, contacts and trails on a floor.
export class MotionStage {
  readonly node = element('div', { class: 'scene' });
  readonly scene: Scene | undefined;
  private readonly tip = element('div', { class: 'overlay', hidden: true });
  private readonly shown = new Set<StagePart>();
  private motion: Motion | undefined;
  private floor: FloorObject | undefined;
  private markers: FigureObject | undefined;
  private joints: FigureObject | undefined;
  private visuals: VisualObject | undefined;
  private contacts: ContactObject | undefined;
  private trails: TrailObject | undefined;
  private trailPoints: readonly number[] = [];
  private time = 0;
  private shownFrame = -1;
  private cameraPlaced = false;
  // Px from the top left of the picture; undefined: outside.
  private pointer: { x: number; y: number } | undefined;

  constructor(
    theme: ThemeSwitch,
    label: string,
    parts: readonly StagePart[],
    newScene: typeof createScene = createScene,
  ) {
    for (const part of parts) this.shown.add(part);
    this.scene = newScene(this.node, { theme, label });
    this.node.append(this.tip);
    this.scene?.canvas.addEventListener('pointermove', (event) => {
      this.pointer = { x: event.offsetX, y: event.offsetY };
      this.showTip();
    });
    this.scene?.canvas.addEventListener('pointerleave', () => {
      this.pointer = undefined;
      this.showTip();
    });
  }

  // Shows another motion. Its blocks can still arrive; call `show` again then.
  setMotion(motion: Motion): void {
    this.clear();
    this.motion = motion;
    const { scene } = this;
    if (!scene) return;
    this.floor = new FloorObject(scene);
    this.markers = new FigureObject(scene, motion.markers);
    const { joints } = motion;
    if (joints.names.length > 0) {
      const style = { color: '--ghost', opacity: 0.55 };
      const capsules = { names: joints.names, bones: bonesWithoutVisuals(joints) };
      this.joints = new FigureObject(scene, capsules, {
        pointRadius: 0.013,
        links: true,
        ...style,
      });
      if (joints.visuals.length > 0) this.visuals = new VisualObject(scene, joints.visuals, style);
    }
    if (motion.contacts.length > 0) this.contacts = new ContactObject(scene, motion.markers.names);
    this.trails = new TrailObject(scene, motion.markers);
    this.setTrailPoints(
      this.trailPoints.length > 0 ? this.trailPoints : endPoints(motion.markers.names),
    );
    this.applyParts();
    this.show(this.time);
  }

  // Call when all frames have arrived: the floor covers the whole path.
  complete(): void {
    if (this.motion) this.floor?.cover(extentOf(this.motion.markers.positions));
  }

  has(part: StagePart): boolean {
    return this.shown.has(part);
  }

  setPart(part: StagePart, shown: boolean): void {
    if (shown) this.shown.add(part);
    else this.shown.delete(part);
    this.applyParts();
    this.shownFrame = -1;
    this.show(this.time);
  }

  setTrailPoints(points: readonly number[]): void {
    this.trailPoints = points;
    this.trails?.show(this.shown.has('trails') ? points : []);
    this.shownFrame = -1;
    this.show(this.time);
  }

  highlight(marker: number): void {
    this.markers?.highlight(marker);
  }

  // Keeps a camera that was restored from a URL.
  keepCamera(): void {
    this.cameraPlaced = true;
  }

  // Shows the frame at a time, in seconds.
  show(time: number): void {
    this.time = time;
    const { motion } = this;
    if (!motion || motion.frameCount === 0) return;
    const frame = frameAt(motion, time);
    // Frames that have not arrived yet are drawn again.
    if (frame === this.shownFrame && frame < motion.receivedFrames) return;
    this.shownFrame = frame < motion.receivedFrames ? frame : -1;
    const positions = frameOf(motion.markers, frame);
    this.markers?.update(positions);
    const joints = frameOf(motion.joints, frame);
    this.joints?.update(joints);
    this.visuals?.update(joints, rotationsOf(motion.joints, frame));
    this.contacts?.update(motion.contacts[frame] ?? 0, positions);
    if (this.shown.has('trails'))
      this.trails?.update(frame, Math.round(kTrailSeconds * motion.frameRateHz));
    this.moveCamera(positions);
    if (this.pointer) this.showTip();
  }

  // Shows no motion.
  clear(): void {
    const { floor, markers, joints, visuals, contacts, trails } = this;
    for (const part of [floor, markers, joints, visuals, contacts, trails]) part?.dispose();
    this.floor = this.markers = this.joints = this.contacts = this.trails = undefined;
    this.visuals = undefined;
    this.motion = undefined;
    this.shownFrame = -1;
    this.scene?.invalidate();
  }

  dispose(): void {
    this.clear();
    this.scene?.dispose();
    this.node.remove();
  }

  private moveCamera(positions: Float32Array): void {
    if (!this.scene) return;
    const center = centerOf(positions);
    if (!center) return;
    if (!this.cameraPlaced) {
      this.cameraPlaced = true;
      const [x, y] = center;
      this.scene.orbit.place([x + 2.6, y - 2.9, 1.7], [x, y, 0.9]);
    } else if (this.shown.has('follow')) {
      this.scene.orbit.follow(center[0], center[1], this.scene.orbit.target.z);
    }
  }

  private applyParts(): void {
    if (this.markers) this.markers.visible = this.shown.has('markers');
    for (const part of [this.joints, this.visuals])
      if (part) part.visible = this.shown.has('joints');
    if (this.contacts) this.contacts.visible = this.shown.has('contacts');
    this.trails?.show(this.shown.has('trails') ? this.trailPoints : []);
  }

  // Names the shown marker or joint next to the pointer, with its position.
  private showTip(): void {
    const marker = this.pointedIn(this.markers);
    const joint = this.pointedIn(this.joints);
    const isJoint = joint && (!marker || joint.distance < marker.distance);
    const found = isJoint ? joint : marker;
    this.tip.hidden = found === undefined;
    if (!found) return;
    const { figure, point } = found;
    const at = figure.positionOf(point).map((value) => value.toFixed(3));
    const name = figure.figure.names[point] ?? '';
    this.tip.textContent = `${name}  x ${at[0] ?? ''}  y ${at[1] ?? ''}  z ${at[2] ?? ''} m`;
  }

  private pointedIn(figure: FigureObject | undefined) {
    const { pointer } = this;
    const nearest = figure?.visible ? pointer && figure.nearestTo(pointer.x, pointer.y) : undefined;
    return figure && nearest && { figure, ...nearest };
  }
}

// Hands and feet.
export function endPoints(names: readonly string[]): number[] {
  return names.flatMap((name, point) => (/hand|wrist|toe|ankle/i.test(name) ? [point] : []));
}

// Mean x and y of a frame; undefined if all points are missing.
export function centerOf(positions: Float32Array): [number, number] | undefined {
  let x = 0;
  let y = 0;
  let count = 0;
  for (let index = 0; index + 2 < positions.length; index += 3) {
    const px = positions[index] ?? NaN;
    if (Number.isNaN(px)) continue;
    x += px;
    y += positions[index + 1] ?? 0;
    ++count;
  }
  return count === 0 ? undefined : [x / count, y / count];
}

const kPartTexts: Record<StagePart, string> = {
  markers: 'Markers',
  joints: 'Recorded skeleton',
  contacts: 'Contacts',
  trails: 'Trails',
  follow: 'Follow camera',
};

// Check boxes of what a stage draws.
export function partChoices(
  shown: readonly StagePart[],
  change: (part: StagePart, on: boolean) => void,
): HTMLElement {
  const group = element('div', { class: 'row', role: 'group', 'aria-label': 'Shown parts' });
  for (const part of kStageParts) {
    const box = element('input', { type: 'checkbox', checked: shown.includes(part) });
    box.addEventListener('change', () => {
      change(part, box.checked);
    });
    group.append(labelled(kPartTexts[part], box, { class: 'field inline' }));
  }
  return group;
}
