import type { FloorPosition, FloorXY, ObstacleShape } from './floor_geometry';

// Text of obstacles for the URL: `d1.5,0,0.4` for a disc, `p0,0,1,0,1,1` for a polygon.
export function obstaclesText(shapes: readonly ObstacleShape[]): string {
  return shapes
    .map((shape) =>
      shape.kind === 'disc'
        ? `d${numbersText([shape.centre.x, shape.centre.y, shape.radius])}`
        : `p${numbersText(shape.corners.flatMap(({ x, y }) => [x, y]))}`,
    )
    .join('_');
}

// The obstacles of a text; parts that are not valid are left out.
export function obstaclesOf(text: string): ObstacleShape[] {
  return text.split('_').flatMap((part): ObstacleShape[] => {
    const values = numbersOf(part.slice(1));
    if (part.startsWith('d') && values.length === 3 && values[2]! > 0) {
      return [{ kind: 'disc', centre: { x: values[0]!, y: values[1]! }, radius: values[2]! }];
    }
    if (part.startsWith('p') && values.length >= 6 && values.length % 2 === 0) {
      const corners: FloorXY[] = [];
      for (let i = 0; i < values.length; i += 2) corners.push({ x: values[i]!, y: values[i + 1]! });
      return [{ kind: 'polygon', corners }];
    }
    return [];
  });
}

// Text of a pose, `x,y,heading`.
export function poseTextOf(pose: FloorPosition): string {
  return numbersText([pose.x, pose.y, pose.heading]);
}

// The pose of a text; undefined if it is not valid.
export function poseOf(text: string): FloorPosition | undefined {
  const [x, y, heading] = numbersOf(text);
  return x === undefined || y === undefined || heading === undefined
    ? undefined
    : { x, y, heading };
}

function numbersText(values: number[]): string {
  return values.map((value) => String(Number(value.toFixed(3)))).join(',');
}

function numbersOf(text: string): number[] {
  const values = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  return values.every(Number.isFinite) ? values : [];
}
