import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { FloorEditor } from './floor_editor';

const [kWidth, kHeight] = [600, 400];
const edits = { setPose: vi.fn(), setObstacles: vi.fn(), announce: vi.fn() };

beforeEach(() => {
  vi.clearAllMocks();
  vi.stubGlobal(
    'ResizeObserver',
    class {
      observe = vi.fn();
      disconnect = vi.fn();
    },
  );
});
afterEach(() => {
  vi.unstubAllGlobals();
});

function openFloor() {
  const poses = { start: { x: 0, y: 0, heading: 0 }, goal: { x: 1, y: 1, heading: 0.5 } };
  const floor = new FloorEditor(poses, [], edits);
  document.body.replaceChildren(floor.node);
  const svg = floor.node.querySelector('svg')!;
  Object.defineProperty(svg, 'clientWidth', { value: kWidth });
  Object.defineProperty(svg, 'clientHeight', { value: kHeight });
  svg.setPointerCapture = vi.fn();
  floor.fit();
  // Finger 1 is the first one.
  const touch = (type: string, pointerId: number, clientX: number, clientY: number) => {
    const event = new MouseEvent(`pointer${type}`, { clientX, clientY });
    svg.dispatchEvent(Object.assign(event, { pointerId, isPrimary: pointerId === 1 }));
  };
  // Places in the picture, px.
  const placeOf = (css: string) => {
    const node = svg.querySelector(css)!;
    return ['cx', 'cy'].map((name) => Number(node.getAttribute(name)));
  };
  const tool = (key: string) => {
    svg.dispatchEvent(new KeyboardEvent('keydown', { key }));
  };
  return { svg, touch, placeOf, tool };
}

const distance = (a: readonly number[], b: readonly number[]) =>
  Math.hypot(a[0]! - b[0]!, a[1]! - b[1]!);

// The distance of start and goal, px.
function apart({ placeOf }: ReturnType<typeof openFloor>): number {
  return distance(placeOf('.start circle'), placeOf('.goal circle'));
}

test('one finger places the goal and turns it', () => {
  const { touch, placeOf } = openFloor();
  touch('down', 1, 120, 90);
  touch('move', 1, 120, 30);
  touch('up', 1, 120, 30);
  expect(distance(placeOf('.goal circle'), [120, 90])).toBeLessThan(1e-6);
  const [tool, pose] = edits.setPose.mock.lastCall as [string, { heading: number }];
  expect(tool).toBe('goal');
  expect(pose.heading).toBeCloseTo(0);
});

test('two fingers zoom and move the floor, and place no goal', () => {
  const floor = openFloor();
  const { touch, placeOf } = floor;
  const [before, start] = [apart(floor), placeOf('.start circle')];
  touch('down', 1, start[0]!, start[1]!);
  touch('down', 2, start[0]! + 100, start[1]!);
  expect(edits.setPose.mock.lastCall).toEqual(['goal', { x: 1, y: 1, heading: 0.5 }]);
  const changes = edits.setPose.mock.calls.length;
  touch('move', 2, start[0]! + 200, start[1]!);
  expect(apart(floor)).toBeCloseTo(2 * before);
  // What is below a finger stays there.
  expect(placeOf('.start circle')[0]).toBeCloseTo(start[0]!);
  touch('move', 1, start[0]! + 50, start[1]! + 30);
  touch('move', 2, start[0]! + 250, start[1]! + 30);
  expect(apart(floor)).toBeCloseTo(2 * before, -1);
  expect(placeOf('.start circle')[0]).toBeCloseTo(start[0]! + 50, 0);
  // A finger that stays draws nothing.
  const moved = placeOf('.start circle');
  touch('up', 2, start[0]! + 250, start[1]! + 30);
  touch('move', 1, 10, 10);
  touch('up', 1, 10, 10);
  expect(placeOf('.start circle')).toEqual(moved);
  expect(edits.setPose.mock.calls.length).toBe(changes);
  // The next finger draws.
  touch('down', 1, 50, 60);
  touch('up', 1, 50, 60);
  expect(distance(placeOf('.goal circle'), [50, 60])).toBeLessThan(1e-6);
});

test('two fingers add no corner and no disc', () => {
  const { svg, touch, tool } = openFloor();
  const pinch = () => {
    touch('down', 1, 100, 100);
    touch('down', 2, 200, 100);
    touch('move', 2, 220, 100);
    touch('up', 2, 220, 100);
    touch('up', 1, 100, 100);
  };
  tool('d');
  pinch();
  expect(svg.querySelectorAll('.obstacle').length).toBe(0);
  tool('p');
  touch('down', 1, 50, 50);
  touch('up', 1, 50, 50);
  pinch();
  tool('Delete'); // the only corner
  expect(svg.querySelectorAll('.draft').length).toBe(0);
  expect(edits.announce).toHaveBeenLastCalledWith('Nothing is drawn.');
  expect(edits.setObstacles).not.toHaveBeenCalled();
});
