// The poses of a map are those of its model, also after another client has built a new one.
import { create, toBinary } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { Connection } from '../../api/connection';
import { ErrorInfoSchema } from '../../api/messages';
import { floatBytes } from '../../drawing/float_bytes';
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

function superseded(): ConnectError {
  const error = new ConnectError('model 1 was replaced', Code.FailedPrecondition);
  const value = toBinary(ErrorInfoSchema, create(ErrorInfoSchema, { reason: 'MODEL_SUPERSEDED' }));
  error.details.push({ type: 'google.rpc.ErrorInfo', value });
  return error;
}

// A database of which only the model with the number `current` can be read. The marker of the mean
// pose of node 4 is at that height.
function databaseOf() {
  const model = { current: 1 };
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
  const api = { views: { getNodePoses, readStateMap, getFigure }, databases: { getDatabase } };
  return { model, api: api as unknown as Api, getNodePoses };
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
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const connection = new Connection(() => Promise.resolve());
  const setQuery = vi.fn();
  const context = { api, theme, connection, setQuery, announce: vi.fn() };
  const host = document.createElement('main');
  const params = { database: 'demo', path: [], query: new URLSearchParams('node=4') };
  const view = open(host, context as unknown as ViewContext, params);
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
