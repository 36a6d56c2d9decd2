import { create } from '@bufbuild/protobuf';
import { describe, expect, it, test } from 'vitest';
import { FileFormat, PlannedMotionSchema, VisualGeometry } from '../../api/messages';
import { planRequest, rootPath, stageMotion } from './plan_messages';
import { planSettingsOf, queryOfPlan } from './plan_settings';
import { floatBytes, frameOf, rotationsOf } from '../../motion/motion';

const query = new URLSearchParams({
  clip: 'walk',
  time: '1.5',
  goal: '2,1,0.5',
  obstacles: 'd1,0,0.3_p0,1,1,1,1,2',
  alternatives: '3',
  seed: '7',
  filter: 'label = walk',
  method: 'paper',
  motion: '2',
});

describe('settings of a plan in the URL', () => {
  it('come back unchanged', () => {
    const values = queryOfPlan(planSettingsOf(query));
    for (const [name, value] of query) expect(String(values[name])).toBe(value);
  });
});

describe('a start elsewhere on the floor', () => {
  const settings = planSettingsOf(
    new URLSearchParams({ start: '2,1,1.571', goal: '2,3,3', obstacles: 'd1,1,0.3_p2,2,3,2,3,3' }),
  );
  const { goal, obstacles } = planRequest('demo', settings, undefined);

  it('is the frame of goal and obstacles', () => {
    // The start looks to the left: the goal is 2 m in front of it.
    expect(goal?.xM).toBeCloseTo(2, 2);
    expect(goal?.yM).toBeCloseTo(0, 2);
    expect(goal?.headingRad).toBeCloseTo(3 - 1.571);
    expect(obstacles?.discs?.[0]?.centre?.xM).toBeCloseTo(0, 2);
    expect(obstacles?.discs?.[0]?.centre?.yM).toBeCloseTo(1, 2);
    expect(obstacles?.polygons?.[0]?.corners?.[2]?.xM).toBeCloseTo(2, 2);
    expect(obstacles?.polygons?.[0]?.corners?.[2]?.yM).toBeCloseTo(-1, 2);
  });

  it('is undone for the paths of the answer', () => {
    const origin = { xM: 0, yM: 0, headingRad: 0 };
    const planned = create(PlannedMotionSchema, { root: [origin, { ...origin, ...goal }] });
    const [first, last] = rootPath(planned, settings.start);
    for (const key of ['x', 'y', 'heading'] as const) {
      expect(first?.[key]).toBeCloseTo(settings.start[key]);
      expect(last?.[key]).toBeCloseTo(settings.goal[key]);
    }
  });

  it('comes back in the URL', () => {
    expect(queryOfPlan(settings)['start']).toBe('2,1,1.571');
    expect(queryOfPlan(planSettingsOf(new URLSearchParams()))['start']).toBeNull();
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

test('a planned motion of a robot has its joints and their shapes', () => {
  const planned = create(PlannedMotionSchema, {
    frameRateHz: 60,
    frameCount: 2,
    markerNames: ['head'],
    markerPositions: floatBytes(Float32Array.from([1, 2, 3, 4, 5, 6])),
    jointNames: ['base'],
    jointPositions: floatBytes(Float32Array.from([0, 0, 1, 0, 0, 2])),
    jointVisuals: [{ joint: 0, geometry: VisualGeometry.SPHERE, sizeM: [1, 1, 1] }],
    jointRotations: floatBytes(Float32Array.from([0, 0, 0, 1, 0, 0, 1, 0])),
  });
  const motion = stageMotion('plan', planned, []);
  expect(motion.receivedFrames).toBe(2);
  expect([...frameOf(motion.markers, 1)]).toEqual([4, 5, 6]);
  expect([...frameOf(motion.joints, 1)]).toEqual([0, 0, 2]);
  expect([...rotationsOf(motion.joints, 1)]).toEqual([0, 0, 1, 0]);
  expect(motion.joints.visuals.map(({ geometry }) => geometry)).toEqual([VisualGeometry.SPHERE]);
});
