import {
  contains,
  distance,
  polygonError,
  type FloorXY,
  type ObstacleShape,
} from './floor_geometry';

const kFirstRadius = 0.3;
const kLeastRadius = 0.05;

// The obstacles while a user draws them, with a pointer or with a cursor that keys move. Lengths
// in m.
export class ObstacleDrawing {
  // The shape that is not finished.
  draft: ObstacleShape | undefined;
  // Index of the chosen obstacle; -1: none.
  chosen = -1;

  constructor(
    public obstacles: readonly ObstacleShape[],
    private readonly changed: (obstacles: ObstacleShape[]) => void,
  ) {}

  // Begins a disc, or moves the one that is being drawn.
  placeDisc(centre: FloorXY): void {
    this.draft = { kind: 'disc', centre, radius: this.radius };
  }

  // Of the disc that is being drawn, or of the next one.
  get radius(): number {
    return this.draft?.kind === 'disc' ? this.draft.radius : kFirstRadius;
  }

  resizeDisc(radius: number): void {
    if (this.draft?.kind !== 'disc') return;
    this.draft = { ...this.draft, radius: Math.max(kLeastRadius, radius) };
  }

  // A corner at the place of the last one is the same corner.
  addCorner(corner: FloorXY): void {
    const corners = this.draft?.kind === 'polygon' ? this.draft.corners : [];
    const last = corners.at(-1);
    if (last && distance(last, corner) < 0.02) return;
    this.draft = { kind: 'polygon', corners: [...corners, corner] };
  }

  // Adds the draft to the obstacles. Returns why it is no valid obstacle; empty: it was added.
  finish(): string {
    const { draft } = this;
    if (!draft) return 'Expected an obstacle that is being drawn.';
    const error = draft.kind === 'polygon' ? polygonError(draft.corners) : '';
    if (error === '') {
      this.draft = undefined;
      this.change([...this.obstacles, draft]);
    }
    return error;
  }

  // A double click adds two discs: removes the first one.
  joinDoubleClick(): void {
    const first = this.obstacles.length - 2;
    if (first >= 0) this.change(this.obstacles.filter((_, i) => i !== first));
  }

  choose(at: FloorXY): void {
    this.chosen = this.obstacles.findIndex((shape) => contains(shape, at));
  }

  // Removes the last corner of the draft, or a draft without more corners; without a draft the chosen
  // obstacle, or the last one.
  remove(): void {
    const { draft } = this;
    if (draft) {
      const corners = draft.kind === 'polygon' ? draft.corners.slice(0, -1) : [];
      this.draft = corners.length > 0 ? { kind: 'polygon', corners } : undefined;
      return;
    }
    const at = this.chosen >= 0 ? this.chosen : this.obstacles.length - 1;
    this.chosen = -1;
    this.change(this.obstacles.filter((_, i) => i !== at));
  }

  private change(obstacles: ObstacleShape[]): void {
    this.obstacles = obstacles;
    this.changed(obstacles);
  }
}
