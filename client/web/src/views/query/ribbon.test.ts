import { beforeEach, expect, test, vi } from 'vitest';
import { RecognitionRibbon } from './ribbon';

const windows = [0, 1, 2, 3].map((second) => ({
  startSeconds: second,
  endSeconds: second + 1,
  labels: [{ label: second < 2 ? 'walk' : 'run', probability: 1 }],
  familiarity: 1,
}));

const seek = vi.fn();

function openRibbon() {
  const ribbon = new RecognitionRibbon(seek);
  document.body.replaceChildren(ribbon.node);
  const picture = ribbon.node.querySelector('svg')!;
  picture.getBoundingClientRect = () => ({ left: 0, width: 400 }) as DOMRect;
  const show = (duration = 4) => {
    ribbon.show(windows as never, duration, new Map());
  };
  show();
  ribbon.mark(1);
  // The part that is shown, s.
  const shown = (duration = 4) => {
    const [left, , width] = picture.getAttribute('viewBox')!.split(' ').map(Number);
    return [left, left! + width!].map((x) => Number(((x! * duration) / 1000).toFixed(3)));
  };
  const press = (key: string) => {
    picture.dispatchEvent(new KeyboardEvent('keydown', { key, cancelable: true }));
  };
  const touch = (type: string, pointerId: number, clientX: number) => {
    const event = new MouseEvent(type, { clientX });
    picture.dispatchEvent(Object.assign(event, { pointerId, pointerType: 'touch' }));
  };
  return { ribbon, picture, show, shown, press, touch };
}

beforeEach(() => {
  seek.mockClear();
});

test('keys zoom about the present time, and a click goes to the time below it', () => {
  const { picture, shown, press } = openRibbon();
  expect(shown()).toEqual([0, 4]);
  press('+');
  expect(shown()).toEqual([0.333, 3]);
  picture.dispatchEvent(new MouseEvent('click', { clientX: 300 }));
  expect(seek.mock.lastCall![0]).toBeCloseTo(1 / 3 + (0.75 * 8) / 3, 9);
  press('0');
  expect(shown()).toEqual([0, 4]);
});

test('the wheel and two fingers zoom, a double click shows all', () => {
  const { picture, shown, touch } = openRibbon();
  picture.dispatchEvent(
    new WheelEvent('wheel', { clientX: 200, deltaY: -500 * Math.log(2), cancelable: true }),
  );
  expect(shown()).toEqual([1, 3]);
  picture.dispatchEvent(new MouseEvent('dblclick'));
  expect(shown()).toEqual([0, 4]);
  Object.defineProperty(picture, 'clientWidth', { value: 400 });
  touch('pointerdown', 1, 100);
  touch('pointerdown', 2, 300);
  touch('pointermove', 1, 0);
  touch('pointermove', 2, 400);
  expect(shown()).toEqual([1, 3]);
  touch('pointerup', 1, 0);
  touch('pointermove', 2, 300);
  expect(shown()).toEqual([1, 3]);
});

test('the part that is shown follows the motion that plays', () => {
  const { ribbon, show, shown, press } = openRibbon();
  press('+');
  ribbon.mark(2.9);
  expect(shown()).toEqual([0.333, 3]);
  ribbon.mark(3.1);
  expect(shown()).toEqual([1.333, 4]);
  ribbon.mark(0);
  expect(shown()).toEqual([0, 2.667]);
  // Other colours keep the zoom, another motion does not.
  show();
  expect(shown()).toEqual([0, 2.667]);
  show(8);
  expect(shown(8)).toEqual([0, 8]);
});

test('the hatching has the same lines at each zoom', () => {
  const { picture, press } = openRibbon();
  press('+');
  const pattern = picture.querySelector('pattern')!;
  const [, scale] = /scale\(([\d.]+) 1\)/.exec(pattern.getAttribute('patternTransform')!)!;
  expect(Number(scale)).toBeCloseTo(2 / 3, 9);
});
