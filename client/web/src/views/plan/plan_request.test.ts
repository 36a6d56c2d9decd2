import { describe, expect, it } from 'vitest';
import { FileFormat } from '../../api/messages';
import { planRequest } from './plan_request';
import { planSettingsOf, queryOfPlan } from './plan_settings';

const query = new URLSearchParams({
  clip: 'walk',
  time: '1.5',
  goal: '2,1,0.5',
  obstacles: 'd1,0,0.3_p0,1,1,1,1,2',
  alternatives: '3',
  seed: '7',
  filter: 'label = walk',
  method: 'paper',
});

describe('settings of a plan in the URL', () => {
  it('come back unchanged', () => {
    const values = queryOfPlan(planSettingsOf(query));
    for (const [name, value] of query) expect(String(values[name])).toBe(value);
  });
});

describe('planRequest', () => {
  it('has the start, goal and obstacles of the settings', () => {
    const request = planRequest('demo', planSettingsOf(query), undefined);
    expect(request).toMatchObject({
      database: 'databases/demo',
      goal: { xM: 2, yM: 1, headingRad: 0.5 },
      start: { case: 'clipStart', value: { clip: 'databases/demo/clips/walk', seconds: 1.5 } },
      obstacles: {
        discs: [{ centre: { xM: 1, yM: 0 }, radiusM: 0.3 }],
        polygons: [
          {
            corners: [
              { xM: 0, yM: 1 },
              { xM: 1, yM: 1 },
              { xM: 1, yM: 2 },
            ],
          },
        ],
      },
      alternativeCount: 3,
      seed: 7,
    });
    expect(request).not.toHaveProperty('includeFiles');
    expect(request).not.toHaveProperty('body');
  });

  it('starts from standing still without a clip, and can ask for files', () => {
    const settings = planSettingsOf(new URLSearchParams());
    const robot = { fileName: 'r.urdf', urdf: new Uint8Array(1) };
    const request = planRequest('demo', settings, robot, FileFormat.GLTF);
    expect(request).not.toHaveProperty('start');
    expect(request).toMatchObject({
      includeFiles: true,
      fileFormat: FileFormat.GLTF,
      body: { case: 'robot', value: robot },
    });
  });
});
