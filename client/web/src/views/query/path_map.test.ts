// The path of nodes is drawn only on the map of the model that answered.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { LabelPalette } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';
import { stateMapOf, stubDrawing } from '../database/test_map';
import { PathMap } from './path_map';
import type { MomentAnswer } from './prediction';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

beforeEach(stubDrawing);
afterEach(() => {
  vi.restoreAllMocks();
});

// A database whose current model has this version, with the nodes 4 and 5. `nodeReads`: how often
// nodes were sent.
function openMap() {
  const model = { version: 1, nodeReads: 0 };
  const readStateMap = () => stateMapOf(model.version, [4, 5], () => ++model.nodeReads);
  const api = { views: { readStateMap } } as unknown as Api;
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const map = new PathMap(api, theme as unknown as ThemeSwitch, 'demo', new LabelPalette());
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
  expect(map.node.textContent).toContain('Path: 4, 5');
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
