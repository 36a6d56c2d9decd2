// A position in the picture, px from its top left.
export interface PicturePlace {
  x: number;
  y: number;
}

// Zoom and movement of a flat picture, changed by fingers, mouse and keys.
export class FlatCamera {
  zoom = 1;
  // Movement of the picture to the right and down, px.
  pan: PicturePlace = { x: 0, y: 0 };
  private readonly fingers = new Map<number, PicturePlace>();
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
    if (this.fingers.size === 0) this.travelled = 0;
    this.fingers.set(pointer, at);
  }

  // One pointer moves the picture, two also zoom it. Returns whether it has changed.
  move(pointer: number, at: PicturePlace): boolean {
    const before = this.fingers.get(pointer);
    if (!before) return false;
    this.fingers.set(pointer, at);
    const [x, y] = [at.x - before.x, at.y - before.y];
    this.travelled += Math.hypot(x, y);
    const other = [...this.fingers].find(([id]) => id !== pointer)?.[1];
    if (!other) {
      this.moveBy(x, y);
      return true;
    }
    const spread = (place: PicturePlace) => Math.hypot(place.x - other.x, place.y - other.y);
    this.moveBy(x / 2, y / 2);
    const middle = { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 };
    this.zoomAt(spread(at) / Math.max(1, spread(before)), middle);
    return true;
  }

  up(pointer: number): void {
    this.fingers.delete(pointer);
  }
}
