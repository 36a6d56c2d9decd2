import { Fingers, type PicturePlace } from '../../dom/fingers';

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
