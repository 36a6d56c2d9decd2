import { expect, test, vi } from 'vitest';
import { create } from '@bufbuild/protobuf';
import { FigureSchema } from '../api/messages';
import { createMotion } from '../motion/motion';
import type { Scene } from '../scene/scene';
import { testScene } from '../scene/test_scene';
import type { ThemeSwitch } from '../shell/theme';
import { MotionStage, type StagePart } from './motion_stage';

// Test files share their modules: as in the others.
vi.mock('../scene/scene', () => ({ createScene: () => undefined }));

// 100 px for each metre along x and z.
const newScene = () =>
  Object.assign(testScene().scene, {
    canvas: document.createElement('canvas'),
    orbit: { place: vi.fn() },
    project: (x: number, _y: number, z: number) => ({ x: 100 * x, y: 100 * z }),
    dispose: vi.fn(),
  }) as unknown as Scene;

// A stage with a marker at 0.1 m and a joint at 0.2 m; returns the tip at a place on x, px.
function openStage(parts: readonly StagePart[]) {
  const stage = new MotionStage({} as ThemeSwitch, 'test', parts, newScene);
  const figure = create(FigureSchema, { markerNames: ['LHand'], jointNames: ['left_wrist'] });
  const motion = createMotion('a', figure, 60, 1, false, true);
  motion.markers.positions.set([0.1, 0, 0]);
  motion.joints.positions.set([0.2, 0, 0]);
  motion.receivedFrames = 1;
  stage.setMotion(motion);
  const tip = stage.node.querySelector<HTMLElement>('.overlay')!;
  const text = () => (tip.hidden ? '' : (tip.textContent.split(' ')[0] ?? ''));
  const tipAt = (x: number) => {
    const event = Object.assign(new Event('pointermove'), { offsetX: x, offsetY: 0 });
    stage.scene?.canvas.dispatchEvent(event);
    return text();
  };
  return { stage, tipAt, text };
}

test('the pointer names the nearest of the markers and joints that are shown', () => {
  const { tipAt } = openStage(['markers', 'joints']);
  expect([10, 14, 16, 20, 40].map(tipAt)).toEqual([
    'LHand',
    'LHand',
    'left_wrist',
    'left_wrist',
    '',
  ]);
});

test('the pointer does not name what is not shown', () => {
  const { stage, tipAt, text } = openStage([]);
  expect([tipAt(10), tipAt(20)]).toEqual(['', '']);
  stage.setPart('joints', true);
  expect([tipAt(10), tipAt(20)]).toEqual(['left_wrist', 'left_wrist']);
  stage.setPart('markers', true);
  stage.setPart('joints', false);
  expect(text()).toBe('LHand');
  stage.setPart('markers', false);
  expect(text()).toBe('');
});
