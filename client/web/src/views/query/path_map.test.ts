// The path of nodes is drawn only on the map of the model that answered.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { floatBytes } from '../../drawing/float_bytes';
import type { ThemeSwitch } from '../../shell/theme';
import { PathMap } from './path_map';
import type { MomentAnswer } from './prediction';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

beforeEach(() => {
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(null);
  vi.stubGlobal(
    'ResizeObserver',
    class {
      observe = vi.fn();
      disconnect = vi.fn();
    },
  );
});
afterEach(() => {
  vi.restoreAllMocks();
});

// A database whose current model has this version, with the nodes 4 and 5. `nodeReads`: how often
// nodes were sent.
function openMap() {
  const model = { version: 1, nodeReads: 0 };
  async function* readStateMap() {
    const counts = { nodeCount: 2, transitionCount: 0, pointCount: 0 };
    const lists = { labels: ['walk'], clips: ['databases/demo/clips/a'], varianceFractions: [1] };
    const header = { modelVersion: model.version, layer: 2, nodesPerLayer: [1, 2] };
    yield { part: { case: 'header', value: { ...header, ...lists, ...counts } } };
    await Promise.resolve();
    ++model.nodeReads;
    const nodes = {
      nodeIds: [4, 5],
      parentIds: [1, 1],
      frameCounts: [20, 10],
      labelFractions: [1, 1],
      mainClips: [0, 0],
      means: floatBytes(Float32Array.of(0, 0, 0, 1, 1, 1)),
      semiAxes: floatBytes(new Float32Array(18)),
    };
    yield { part: { case: 'nodes', value: nodes } };
  }
  const api = { views: { readStateMap } } as unknown as Api;
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const map = new PathMap(api, theme as unknown as ThemeSwitch, 'demo');
  const show = (modelVersion: number) => {
    const estimate = { layer: 2, modelVersion, paths: [{ nodeIds: [4, 4, 5] }] };
    const prediction = { nextNodes: [{ nodeId: 4 }] };
    const answer = { estimate, prediction } as unknown as MomentAnswer;
    return map.show(answer, new AbortController().signal);
  };
  return { model, map, show };
}

test('the map is read once for each stored model', async () => {
  const { model, map, show } = openMap();
  await show(1);
  await show(1);
  expect(map.node.textContent).toContain('Path (yellow): 4, 5');
  expect(model.nodeReads).toBe(1);
  model.version = 2;
  await show(2);
  expect(model.nodeReads).toBe(2);
});

test('a model that was built again meanwhile is an error', async () => {
  const { model, show } = openMap();
  model.version = 2;
  await expect(show(1)).rejects.toThrow('predict again');
});

test('a model that is not stored yet is read each time', async () => {
  const { model, map, show } = openMap();
  model.version = 0;
  // The answer has the version of the stored model before.
  await show(1);
  await show(1);
  expect(map.node.hidden).toBe(false);
  expect(model.nodeReads).toBe(2);
});
