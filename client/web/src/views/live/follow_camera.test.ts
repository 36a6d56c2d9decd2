import { expect, test, vi } from 'vitest';
import { Disposer } from '../../dom/disposer';
import type { ViewContext } from '../../shell/view';
import { StreamWatch } from './stream_watch';

vi.mock('../../chart/line_chart', () => ({
  LineChart: class {
    node = document.createElement('figure');
    setData = vi.fn();
    dispose = vi.fn();
  },
}));

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

const stages: { follow: boolean }[] = [];
class Stage {
  node = document.createElement('div');
  follow = true;
  dispose = vi.fn();
  constructor() {
    stages.push(this);
  }
}

test('a camera that shall not follow does not, also if the choice is made before the picture', async () => {
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(null);
  let figure: (answer: object) => void = () => undefined;
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const api = {
    databases: { getDatabase: () => Promise.resolve({}) },
    views: { getFigure: () => new Promise((resolve) => (figure = resolve)) },
    observe: { watchStream: () => ({ [Symbol.asyncIterator]: () => ({ next: forever }) }) },
  };
  const disposer = new Disposer();
  const context = { api, theme } as unknown as ViewContext;
  const watch = new StreamWatch(context, 'demo', 's', disposer, Stage as never);
  document.body.append(watch.node);
  const follow = watch.node.querySelector<HTMLInputElement>('[type=checkbox]')!;
  void watch.run();
  await new Promise((resolve) => setTimeout(resolve));
  follow.click();
  figure({ figure: {} });
  await vi.waitFor(() => {
    expect(stages.length).toBe(1);
  });
  expect(stages[0]?.follow).toBe(false);
  follow.click();
  expect(stages[0]?.follow).toBe(true);
  disposer.dispose();
  watch.node.remove();
  vi.restoreAllMocks();
});

const forever = () => new Promise(() => undefined);
