// A position in a picture, px.
export interface PicturePlace {
  x: number;
  y: number;
}

// How pointers have moved a picture: what was at `middle` before the shift is zoomed about it after.
export interface FingerMove {
  // Movement of the picture to the right and down, px.
  x: number;
  y: number;
  // 1: no zoom.
  factor: number;
  middle: PicturePlace;
}

// The pointers on a picture. One moves it, two also zoom it, so that what is below them stays there.
export class Fingers {
  private readonly places = new Map<number, PicturePlace>();

  get count(): number {
    return this.places.size;
  }

  down(pointer: number, at: PicturePlace): void {
    this.places.set(pointer, at);
  }

  // Undefined for a pointer that is not down.
  move(pointer: number, at: PicturePlace): FingerMove | undefined {
    const before = this.places.get(pointer);
    if (!before) return undefined;
    this.places.set(pointer, at);
    const [x, y] = [at.x - before.x, at.y - before.y];
    const other = [...this.places].find(([id]) => id !== pointer)?.[1];
    if (!other) return { x, y, factor: 1, middle: at };
    const spread = (place: PicturePlace) => Math.hypot(place.x - other.x, place.y - other.y);
    const middle = { x: (at.x + other.x) / 2, y: (at.y + other.y) / 2 };
    return { x: x / 2, y: y / 2, factor: spread(at) / Math.max(1, spread(before)), middle };
  }

  up(pointer: number): void {
    this.places.delete(pointer);
  }
}
