import type { FloorPosition, ObstacleShape } from './floor_geometry';
import { goalOf, goalText, obstaclesOf, obstaclesText } from './plan_url';

// What is planned. All of it is in the URL; a robot is not.
export interface PlanSettings {
  // Id of the clip of the start; empty: standing still.
  clip: string;
  // Moment of the clip, s.
  time: number;
  goal: FloorPosition;
  obstacles: ObstacleShape[];
  alternatives: number;
  seed: number;
  filter: string;
  // The method of the paper instead of the server's default.
  paper: boolean;
}

export function planSettingsOf(query: URLSearchParams): PlanSettings {
  return {
    clip: query.get('clip') ?? '',
    time: numberOf(query.get('time'), 0, 1e6) ?? 0,
    goal: goalOf(query.get('goal') ?? '') ?? { x: 2, y: 1, heading: 0 },
    obstacles: obstaclesOf(query.get('obstacles') ?? ''),
    alternatives: Math.round(numberOf(query.get('alternatives'), 0, 10) ?? 2),
    seed: Math.round(numberOf(query.get('seed'), 0, 4294967295) ?? 0),
    filter: query.get('filter') ?? '',
    paper: query.get('method') === 'paper',
  };
}

export function queryOfPlan(settings: PlanSettings): Record<string, string | number | null> {
  return {
    clip: settings.clip,
    time: settings.time === 0 ? null : settings.time,
    goal: goalText(settings.goal),
    obstacles: obstaclesText(settings.obstacles),
    alternatives: settings.alternatives === 2 ? null : settings.alternatives,
    seed: settings.seed === 0 ? null : settings.seed,
    filter: settings.filter,
    method: settings.paper ? 'paper' : null,
  };
}

function numberOf(text: string | null, low: number, high: number): number | undefined {
  const value = text === null || text.trim() === '' ? NaN : Number(text);
  return value >= low && value <= high ? value : undefined;
}
