import type { FloorPosition, ObstacleShape, FloorXY } from './floor_geometry';

// What is planned. All of it is in the URL; a robot is not.
export interface PlanSettings {
  // Id of the clip of the start; empty: standing still.
  clip: string;
  // Moment of the clip, s.
  time: number;
  // Where the motion starts on the floor.
  start: FloorPosition;
  goal: FloorPosition;
  obstacles: ObstacleShape[];
  alternatives: number;
  seed: number;
  filter: string;
  // The method of the paper instead of the server's default.
  paper: boolean;
  // Index of the motion that is shown, best first.
  motion: number;
}

// The largest numbers; the smallest ones are 0.
export const kPlanLimits = { time: 1e6, alternatives: 10, seed: 4294967295 };

export function planSettingsOf(query: URLSearchParams): PlanSettings {
  return {
    clip: query.get('clip') ?? '',
    time: numberOf(query.get('time'), kPlanLimits.time) ?? 0,
    start: poseOf(query.get('start') ?? '') ?? { x: 0, y: 0, heading: 0 },
    goal: poseOf(query.get('goal') ?? '') ?? { x: 2, y: 1, heading: 0 },
    obstacles: obstaclesOf(query.get('obstacles') ?? ''),
    alternatives: Math.round(numberOf(query.get('alternatives'), kPlanLimits.alternatives) ?? 2),
    seed: Math.round(numberOf(query.get('seed'), kPlanLimits.seed) ?? 0),
    filter: query.get('filter') ?? '',
    paper: query.get('method') === 'paper',
    motion: Math.round(numberOf(query.get('motion'), kPlanLimits.alternatives) ?? 0),
  };
}

// The settings with lengths and angles as the URL has them, so that a shared address plans the same.
export function roundedAsInUrl(settings: PlanSettings): PlanSettings {
  const rounded = (pose: FloorPosition) => poseOf(poseTextOf(pose)) ?? pose;
  const { start, goal, obstacles } = settings;
  return {
    ...settings,
    start: rounded(start),
    goal: rounded(goal),
    obstacles: obstaclesOf(obstaclesText(obstacles)),
  };
}

export function queryOfPlan(settings: PlanSettings): Record<string, string | number | null> {
  const startText = poseTextOf(settings.start);
  return {
    clip: settings.clip,
    time: settings.time === 0 ? null : settings.time,
    start: startText === '0,0,0' ? null : startText,
    goal: poseTextOf(settings.goal),
    obstacles: obstaclesText(settings.obstacles),
    alternatives: settings.alternatives === 2 ? null : settings.alternatives,
    seed: settings.seed === 0 ? null : settings.seed,
    filter: settings.filter,
    method: settings.paper ? 'paper' : null,
    motion: settings.motion === 0 ? null : settings.motion,
  };
}

function numberOf(text: string | null, most: number): number | undefined {
  const value = text === null || text.trim() === '' ? NaN : Number(text);
  return value >= 0 && value <= most ? value : undefined;
}

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
