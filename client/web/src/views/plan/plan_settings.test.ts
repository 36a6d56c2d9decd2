import { describe, expect, it } from 'vitest';
import {
  planSettingsOf,
  queryOfPlan,
  roundedAsInUrl,
  poseOf,
  poseTextOf,
  obstaclesOf,
  obstaclesText,
} from './plan_settings';
import type { ObstacleShape } from './floor_geometry';

describe('settings of a plan', () => {
  it('come back from their URL exactly, if they are rounded', () => {
    const places = {
      start: { x: 1 / 3, y: -2 / 3, heading: Math.PI },
      goal: { x: 1e-7, y: 2.00049, heading: -1 / 7 },
    };
    const obstacles = [{ kind: 'disc' as const, centre: { x: 1 / 9, y: 1 / 7 }, radius: 1 / 6 }];
    const chosen = { ...planSettingsOf(new URLSearchParams('seed=5')), ...places, obstacles };
    const settings = roundedAsInUrl(chosen);
    const query = Object.entries(queryOfPlan(settings)).map(([key, value]) => [
      key,
      `${value ?? ''}`,
    ]);
    expect(planSettingsOf(new URLSearchParams(query))).toEqual(settings);
    expect(settings.start).toEqual({ x: 0.333, y: -0.667, heading: 3.142 });
  });
});

describe('obstacles in a URL', () => {
  const shapes: ObstacleShape[] = [
    { kind: 'disc', centre: { x: 1.25, y: -0.5 }, radius: 0.4 },
    {
      kind: 'polygon',
      corners: [
        { x: 0, y: 0 },
        { x: 1, y: 0 },
        { x: 1, y: -1.125 },
      ],
    },
  ];

  it('come back unchanged', () => {
    expect(obstaclesOf(obstaclesText(shapes))).toEqual(shapes);
    expect(obstaclesOf(obstaclesText([]))).toEqual([]);
  });

  it('leave out parts that are not valid', () => {
    expect(obstaclesOf('d1,2_d1,2,-1_p1,2,3,4_px,1,2,3,4,5_q1,1,1_d1,1,1')).toHaveLength(1);
    expect(obstaclesOf('<b>')).toEqual([]);
  });
});

describe('goal in a URL', () => {
  it('comes back to 1 mm', () => {
    expect(poseOf(poseTextOf({ x: 2, y: 1, heading: 0.78539 }))).toEqual({
      x: 2,
      y: 1,
      heading: 0.785,
    });
  });

  it('is undefined for other text', () => {
    for (const text of ['', '1,2', '1,2,x', 'Infinity,0,0']) expect(poseOf(text)).toBeUndefined();
  });
});
