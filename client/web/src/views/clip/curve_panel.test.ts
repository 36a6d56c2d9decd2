import { expect, test, vi } from 'vitest';
import { createMotion } from '../../motion/motion';
import type { ThemeSwitch } from '../../shell/theme';
import { CurvePanel } from './curve_panel';

// No chart.
vi.mock('../../chart/line_chart', () => ({
  LineChart: class {
    node = document.createElement('figure');
    setData = vi.fn();
    setMark = vi.fn();
    dispose = vi.fn();
  },
}));

test('the values of the chosen curve follow the moment', () => {
  const figure = { markerNames: ['LHand', 'RHand'], markerBones: [] };
  const motion = createMotion('a', figure as never, 60, 2, false, false);
  motion.markers.positions.set([1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 7]);
  motion.receivedFrames = 2;
  const panel = new CurvePanel({
    theme: {} as ThemeSwitch,
    point: 'RHand',
    kind: '',
    seek: vi.fn(),
    chosen: vi.fn(),
    highlight: vi.fn(),
  });
  const output = panel.node.querySelector('output')!;
  panel.setMotion(motion);
  expect(output.textContent).toBe('x 4.000, y 5.000, z 6.000 m');
  panel.setTime(1 / 60);
  expect(output.textContent).toBe('x 4.000, y 5.000, z 7.000 m');
  const kind = [...panel.node.querySelectorAll('select')].at(-1)!;
  kind.value = 'speed';
  kind.dispatchEvent(new Event('change'));
  expect(output.textContent).toBe('speed 60.000 m/s');
  // While the motion plays, they are not read aloud, and drawn now and then.
  vi.spyOn(performance, 'now').mockReturnValue(Infinity);
  panel.setTime(0, true);
  expect(output.getAttribute('aria-live')).toBe('off');
  panel.setTime(0);
  expect(output.getAttribute('aria-live')).toBe('polite');
  vi.restoreAllMocks();
  panel.dispose();
});
