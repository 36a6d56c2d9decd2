// The poses of a map are those of its model, also after another client has built a new one.
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { Connection } from '../../api/connection';
import { serverError } from '../../api/test_server';
import { floatBytes } from '../../motion/motion';
import type { ViewContext } from '../../shell/view';
import { open } from './database_view';
import { NodePoses } from './node_poses';
import { stateMapOf, stubDrawing } from './test_map';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

beforeEach(() => {
  vi.useFakeTimers();
  stubDrawing();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
});

const superseded = () => serverError(Code.FailedPrecondition, 'MODEL_SUPERSEDED');

// A database of which only the model with the number `current` can be read. The marker of the mean
// pose of node 4 is at that height.
function databaseOf() {
  const model = { current: 1, isWatched: false };
  const getNodePoses = vi.fn(({ parent, nodeIds }: { parent: string; nodeIds: number[] }) => {
    if (parent !== `databases/demo/models/${model.current}`) return Promise.reject(superseded());
    const markerPositions = floatBytes(Float32Array.of(0, 0, model.current));
    const markerVelocities = floatBytes(new Float32Array(3));
    return Promise.resolve({
      poses: nodeIds.map((nodeId) => ({ nodeId, markerPositions, markerVelocities })),
    });
  });
  // Node 5 is at no end of an axis, so its pose is not there before it is chosen.
  const readStateMap = () => stateMapOf(model.current, [4, 5, 6]);
  const getFigure = () => Promise.resolve({ figure: { markerBones: [] } });
  const getDatabase = () => Promise.resolve({ database: {} });
  // Sends the version of each model, first that of the one before the watch.
  async function* watchDatabase(_: unknown, { signal }: { signal: AbortSignal }) {
    let sent = 0;
    while (!signal.aborted) {
      await new Promise((resolve) => setTimeout(resolve, 50));
      if (sent === model.current || !model.isWatched) continue;
      sent = model.current;
      yield { change: { case: 'modelVersion', value: sent }, upToDate: true, revision: 1n };
    }
  }
  const databases = { getDatabase, watchDatabase };
  const api = { views: { getNodePoses, readStateMap, getFigure }, databases };
  return { model, api: api as unknown as Api, getNodePoses };
}

function openView(api: Api, query: string) {
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const connection = new Connection(() => Promise.resolve());
  const setQuery = vi.fn();
  const context = { api, theme, connection, setQuery, announce: vi.fn() };
  const host = document.createElement('main');
  const params = { database: 'demo', path: [], query: new URLSearchParams(query) };
  const view = open(host, context as unknown as ViewContext, params);
  return { view, host, setQuery };
}

test('poses are asked for, and kept, by model', async () => {
  const { model, api } = databaseOf();
  const poses = new NodePoses(api, 'demo', new AbortController().signal);
  const height = async (modelVersion: number) =>
    (await poses.load({ modelVersion, layer: 2 }, [4]))[0]?.positions[2];
  expect(await height(1)).toBe(1);
  model.current = 2;
  expect(await height(2)).toBe(2);
  expect(await height(1)).toBe(1);
});

test('a model that is not stored yet is read as the current one', async () => {
  const { api, getNodePoses } = databaseOf();
  const poses = new NodePoses(api, 'demo', new AbortController().signal);
  const unstored = { modelVersion: 0, layer: 2 };
  await poses.load(unstored, [4]).catch(() => undefined);
  expect(getNodePoses.mock.calls[0]?.[0].parent).toBe('databases/demo/models/current');
  // The next one can be another model.
  for (const height of [7, 8]) {
    const markerPositions = floatBytes(Float32Array.of(0, 0, height));
    const markerVelocities = floatBytes(new Float32Array(3));
    const answer = { poses: [{ nodeId: 4, markerPositions, markerVelocities }] };
    getNodePoses.mockResolvedValueOnce(answer);
    expect((await poses.load(unstored, [4]))[0]?.positions[2]).toBe(height);
  }
});

test('a map of an old model says so and is read again', async () => {
  const { model, api } = databaseOf();
  const { view, host, setQuery } = openView(api, 'node=4');
  await vi.advanceTimersByTimeAsync(200);
  const panel = host.querySelector('.node-panel')!;
  const state = () => [
    panel.textContent.includes('Node 4 of layer 2'),
    panel.textContent.includes('Node 5 of layer 2'),
    panel.querySelectorAll('svg').length,
    [...panel.querySelectorAll('.notice button')].map(({ textContent }) => textContent),
  ];
  expect(state()).toEqual([true, false, 1, []]);
  model.current = 2;
  const row = [...host.querySelectorAll('button')].find((each) => each.textContent === '5');
  row!.click();
  await vi.advanceTimersByTimeAsync(200);
  expect(state()).toEqual([false, true, 0, ['Read the map again']]);
  expect(panel.textContent).toContain('This map is of the old model.');
  panel.querySelector<HTMLButtonElement>('.notice button')!.click();
  await vi.advanceTimersByTimeAsync(200);
  // Node 5 of the new model is another node.
  expect(state()).toEqual([false, false, 0, []]);
  expect(setQuery).toHaveBeenLastCalledWith(expect.objectContaining({ node: null }));
  view.close();
});

test('a rebuild by another client is reported', async () => {
  const { model, api } = databaseOf();
  model.isWatched = true;
  const { view, host } = openView(api, '');
  await vi.advanceTimersByTimeAsync(200);
  const notice = host.querySelector('.notice')!;
  expect(notice.textContent).toBe('');
  model.current = 2;
  await vi.advanceTimersByTimeAsync(200);
  expect(notice.textContent).toContain('This map is of the old model.');
  notice.querySelector('button')!.click();
  await vi.advanceTimersByTimeAsync(200);
  expect(notice.textContent).toBe('');
  view.close();
});

test('the nodes of the graph of a clip are not those of the database', async () => {
  const { api } = databaseOf();
  const { views } = api as unknown as { views: { readStateMap: unknown } };
  views.readStateMap = ({ clip }: { clip: string }) => {
    if (clip.endsWith('/none')) throw new ConnectError('no clip none', Code.NotFound);
    return stateMapOf(1, clip === '' ? [4, 5, 6] : [5, 6]);
  };
  const { view, host } = openView(api, 'node=4');
  await vi.advanceTimersByTimeAsync(200);
  const panel = host.querySelector('.node-panel')!;
  expect(panel.textContent).toContain('Node 4 of layer 2');
  const clip = host.querySelector<HTMLInputElement>('input[name=clip], input[list]')!;
  const choose = async (text: string) => {
    clip.value = text;
    clip.dispatchEvent(new Event('change'));
    await vi.advanceTimersByTimeAsync(200);
  };
  await choose('a');
  expect(panel.textContent).toContain('Point at a node');
  // The first node has the place of node 4 before.
  [...host.querySelectorAll('button')].find((each) => each.textContent === '5')!.click();
  await vi.advanceTimersByTimeAsync(200);
  expect(panel.textContent).toContain('Node 5 of layer 2');
  await choose('none');
  expect(host.querySelector('.notice')?.textContent).toContain('no clip none');
  expect(panel.closest<HTMLElement>('[hidden]')).not.toBeNull();
  view.close();
});
