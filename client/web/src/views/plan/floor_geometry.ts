// A point on the floor: x to the front, y to the left, m. The frame of the floor is that of the page;
// the server uses the frame of the start (`toFrame`).
export interface FloorXY {
  x: number;
  y: number;
}

// A pose on the floor; heading counter-clockwise from the front, rad.
export interface FloorPosition extends FloorXY {
  heading: number;
}

// A round obstacle.
export interface DiscShape {
  kind: 'disc';
  centre: FloorXY;
  radius: number;
}

// A polygonal obstacle.
export interface PolygonShape {
  kind: 'polygon';
  corners: FloorXY[];
}

export type ObstacleShape = DiscShape | PolygonShape;

// Heading of a drag from one point to another, in (-pi, pi]; undefined for a drag below `least`.
export function headingOf(from: FloorXY, to: FloorXY, least = 0.05): number | undefined {
  return distance(from, to) < least ? undefined : Math.atan2(to.y - from.y, to.x - from.x);
}

// The angle in (-pi, pi].
export function normalAngle(angle: number): number {
  const turn = 2 * Math.PI;
  const rest = (((angle + Math.PI) % turn) + turn) % turn;
  return rest === 0 ? Math.PI : rest - Math.PI;
}

export function distance(a: FloorXY, b: FloorXY): number {
  return Math.hypot(a.x - b.x, a.y - b.y);
}

// Text of a place, for those who do not see the floor.
export function placeText({ x, y }: FloorXY): string {
  // Adding 0 makes -0 to 0.
  const tenths = (value: number) => (Math.round(10 * value) / 10 + 0).toFixed(1);
  return `${tenths(x)} m ahead, ${tenths(y)} m to the left`;
}

export function poseText(pose: FloorPosition): string {
  const degrees = Math.round((180 / Math.PI) * pose.heading) + 0;
  return `${placeText(pose)}, heading ${degrees} degrees`;
}

export function obstacleText(shape: ObstacleShape): string {
  return shape.kind === 'disc'
    ? `Disc, radius ${shape.radius.toFixed(2)} m, ${placeText(shape.centre)}`
    : `Polygon, ${shape.corners.length} corners, ${placeText(shape.corners[0]!)}`;
}

// A point of the floor in the frame of a pose on the floor.
export function toFrame(frame: FloorPosition, point: FloorXY): FloorXY {
  return rotate({ x: point.x - frame.x, y: point.y - frame.y }, -frame.heading);
}

// The inverse of `toFrame`.
export function fromFrame(frame: FloorPosition, point: FloorXY): FloorXY {
  const { x, y } = rotate(point, frame.heading);
  return { x: frame.x + x, y: frame.y + y };
}

function rotate({ x, y }: FloorXY, angle: number): FloorXY {
  const [cosine, sine] = [Math.cos(angle), Math.sin(angle)];
  return { x: cosine * x - sine * y, y: sine * x + cosine * y };
}

// Whether a point is in or on an obstacle.
export function contains(shape: ObstacleShape, point: FloorXY): boolean {
  if (shape.kind === 'disc') return distance(shape.centre, point) <= shape.radius;
  let inside = false;
  edgesOf(shape.corners).forEach(([a, b]) => {
    const crosses = a.y > point.y !== b.y > point.y;
    if (crosses && point.x < a.x + ((point.y - a.y) / (b.y - a.y)) * (b.x - a.x)) inside = !inside;
  });
  return inside;
}

// Why corners are no valid obstacle: fewer than three different ones, or edges that cross. Empty if
// they are valid.
export function polygonError(corners: readonly FloorXY[]): string {
  if (corners.length < 3) return 'Expected at least 3 corners of an obstacle.';
  const edges = edgesOf(corners);
  if (edges.some(([a, b]) => distance(a, b) === 0)) return 'Two successive corners are equal.';
  for (let i = 0; i < edges.length; ++i) {
    for (let j = i + 1; j < edges.length; ++j) {
      const neighbours = j === i + 1 || (i === 0 && j === edges.length - 1);
      if (neighbours ? foldsBack(edges[i]!, edges[j]!) : meet(edges[i]!, edges[j]!)) {
        return 'Edges of the obstacle cross: draw its corners in order around it.';
      }
    }
  }
  return '';
}

// Places at every `step` s of a path, with the last one: the circles of Fig. 16.
export function placesEvery<T>(path: readonly T[], frameRateHz: number, step = 1 / 6): T[] {
  const places: T[] = [];
  for (let i = 0; ; ++i) {
    const frame = Math.round(i * step * frameRateHz);
    if (frame >= path.length) break;
    places.push(path[frame]!);
  }
  const last = path.at(-1);
  if (last !== undefined && places.at(-1) !== last) places.push(last);
  return places;
}

type Edge = [FloorXY, FloorXY];

function edgesOf(corners: readonly FloorXY[]): Edge[] {
  return corners.map((corner, i) => [corner, corners[(i + 1) % corners.length]!]);
}

function side(a: FloorXY, b: FloorXY, c: FloorXY): number {
  return Math.sign((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
}

function onEdge([a, b]: Edge, p: FloorXY): boolean {
  return (
    side(a, b, p) === 0 &&
    Math.min(a.x, b.x) <= p.x &&
    p.x <= Math.max(a.x, b.x) &&
    Math.min(a.y, b.y) <= p.y &&
    p.y <= Math.max(a.y, b.y)
  );
}

function meet(first: Edge, second: Edge): boolean {
  const [a, b] = first;
  const [c, d] = second;
  const crosses = side(a, b, c) !== side(a, b, d) && side(c, d, a) !== side(c, d, b);
  return crosses || onEdge(first, c) || onEdge(first, d) || onEdge(second, a) || onEdge(second, b);
}

// Neighbours share one corner; they overlap if the far corner of one lies on the other.
function foldsBack(first: Edge, second: Edge): boolean {
  const shared = first.find((corner) => second.includes(corner));
  return (
    [...first, ...second].some(
      (corner) => corner !== shared && onEdge(first, corner) && onEdge(second, corner),
    ) ||
    [first, second].some((edge, i) => {
      const other = i === 0 ? second : first;
      return other.some((corner) => corner !== shared && onEdge(edge, corner));
    })
  );
}
