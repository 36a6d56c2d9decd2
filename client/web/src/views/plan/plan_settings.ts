import type { FloorPosition, ObstacleShape } from './floor_geometry';
import { poseOf, poseTextOf, obstaclesOf, obstaclesText } from './plan_url';

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
