import { describe, expect, it } from 'vitest';
import { planSettingsOf, queryOfPlan, roundedAsInUrl } from './plan_settings';

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
