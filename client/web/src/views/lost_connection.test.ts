// Panels read again what failed when the connection was lost.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from '../api/connection';
import {
  GetServerStatusResponseSchema,
  OperationSchema,
  PlannedMotionSchema,
} from '../api/messages';
import { Disposer } from '../dom/disposer';
import { PlaybackClock } from '../player/playback_clock';
import { LabelPalette } from '../drawing/palette';
import type { ViewContext } from '../shell/view';
import { BackupPanel } from './admin/backup_panel';
import { OperationsPanel } from './admin/operations_panel';
import { StatusPanel } from './admin/status_panel';
import { TokensPanel } from './admin/tokens_panel';
import { ComparePanel } from './clip/compare_panel';
import type { MotionPane } from './clip/motion_pane';
import { NodePanel } from './database/node_panel';
import { NodePoses } from './database/node_poses';
import type { StateMap } from './database/state_map';
import { open as openLive } from './live/live_view';
import { open as openPlan } from './plan/plan_view';
import { ProfilePanel } from './query/profile_panel';

vi.mock('./query/profile_chart', () => ({
  ProfileChart: class {
    node = document.createElement('figure');
    constructor(readonly profile: unknown) {}
    setStyles = vi.fn();
    mark = vi.fn();
    dispose() {
      this.node.remove();
    }
  },
}));
vi.mock('../chart/line_chart', () => ({
  LineChart: class {
    node = document.createElement('figure');
    setData = vi.fn();
    dispose = vi.fn();
  },
}));
// No WebGL.
vi.mock('../scene/scene', () => ({ createScene: () => undefined }));

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

// A call that finds no server at first.
function lostOnce<Response>(response: Response) {
  return vi
    .fn(() => Promise.resolve(response))
    .mockImplementationOnce(() => Promise.reject(new ConnectError('gone', Code.Unavailable)));
}

function contextOf(api: unknown) {
  const connection = new Connection(() => Promise.resolve(), 1000);
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const session = { role: 'reader' };
  const context = { api, connection, theme, session, setQuery: vi.fn(), announce: vi.fn() };
  return context as unknown as ViewContext;
}

// What a panel shows while the server does not answer, and 2 s later.
async function beforeAndAfter(shown: () => unknown) {
  await vi.advanceTimersByTimeAsync(100);
  const before = shown();
  await vi.advanceTimersByTimeAsync(2000);
  return [before, shown()];
}

const errorsOf = (node: HTMLElement) => node.querySelectorAll('.notice.error:not([hidden])').length;
const params = { database: 'demo', path: [], query: new URLSearchParams() };

test('generation probability', async () => {
  const recognize = lostOnce({ windows: [] });
  const panel = new ProfilePanel(
    contextOf({ queries: { recognize } }),
    new LabelPalette(),
    vi.fn(),
    vi.fn(),
  );
  const observed = {
    motion: { markers: { positions: new Float32Array(3), names: ['a'] }, frameRateHz: 60 },
  };
  void panel.load({
    database: 'demo',
    observed: observed as never,
    filter: '',
    window: 1,
    layers: [1, 2],
    chosen: vi.fn(),
  });
  const state = () => [panel.node.querySelectorAll('figure').length, errorsOf(panel.node)];
  expect(await beforeAndAfter(state)).toEqual([
    [0, 1],
    [2, 0],
  ]);
});

test('mean pose of a node', async () => {
  const point = new Uint8Array(12);
  const views = {
    getFigure: lostOnce({ figure: { markerBones: [] } }),
    getNodePoses: lostOnce({
      poses: [{ nodeId: 4, markerPositions: point, markerVelocities: point }],
    }),
  };
  const context = contextOf({ views });
  const poses = new NodePoses(context.api, 'demo', new AbortController().signal);
  const panel = new NodePanel(poses, context.connection, vi.fn());
  const nodes = { ids: [4], frameCounts: [20], labelFractions: [1], mainClips: [0] };
  const header = { layer: 2, modelVersion: 1, labels: ['walk'], clips: ['databases/demo/clips/a'] };
  panel.show({ header, nodes } as unknown as StateMap, 0);
  const state = () => [panel.node.querySelectorAll('svg').length, errorsOf(panel.node)];
  expect(await beforeAndAfter(state)).toEqual([
    [0, 1],
    [1, 0],
  ]);
});

test('databases to download', async () => {
  const databases = { listDatabases: lostOnce({ databases: [{ name: 'databases/demo' }] }) };
  const panel = new BackupPanel(contextOf({ databases }), new Disposer(), false);
  const state = () => [panel.node.querySelectorAll('option').length, errorsOf(panel.node)];
  expect(await beforeAndAfter(state)).toEqual([
    [0, 1],
    [1, 0],
  ]);
});

const rowsAndErrors = (node: HTMLElement) => [
  node.querySelectorAll('tbody tr').length,
  errorsOf(node),
];

test('operations', async () => {
  const operation = create(OperationSchema, { database: 'databases/demo' });
  const operations = { listOperations: lostOnce({ operations: [operation] }) };
  const disposer = new Disposer();
  const panel = new OperationsPanel(contextOf({ operations }), disposer);
  expect(await beforeAndAfter(() => rowsAndErrors(panel.node))).toEqual([
    [0, 1],
    [1, 0],
  ]);
  disposer.dispose();
});

test('tokens', async () => {
  const token = { name: 'tokens/1', role: 1, database: '', revokeTime: { seconds: 1n, nanos: 0 } };
  const access = { listTokens: lostOnce({ tokens: [token], nextPageToken: '' }) };
  const panel = new TokensPanel(contextOf({ access }), new Disposer());
  expect(await beforeAndAfter(() => rowsAndErrors(panel.node))).toEqual([
    [0, 1],
    [1, 0],
  ]);
});

test('the status of the server', async () => {
  const status = create(GetServerStatusResponseSchema, { databases: [{ name: 'databases/demo' }] });
  const server = { getServerStatus: lostOnce(status) };
  const disposer = new Disposer();
  const panel = new StatusPanel(contextOf({ server }), disposer);
  expect(await beforeAndAfter(() => rowsAndErrors(panel.node))).toEqual([
    [0, 1],
    [1, 0],
  ]);
  disposer.dispose();
});

test('live streams', async () => {
  const listStreams = lostOnce({ streams: [{ name: 'databases/demo/streams/1', frame: 1n }] });
  const host = document.createElement('main');
  const view = openLive(host, contextOf({ observe: { listStreams } }), params);
  expect(await beforeAndAfter(() => rowsAndErrors(host))).toEqual([
    [0, 1],
    [1, 0],
  ]);
  view.close();
});

test('names of clips to compare with', async () => {
  const clips = { listClips: lostOnce({ clips: [{ name: 'databases/demo/clips/a' }] }) };
  const panel = new ComparePanel(
    contextOf({ clips }),
    params,
    new PlaybackClock(1, 60),
    new Disposer(),
    document.createElement('div'),
    {} as MotionPane,
  );
  panel.node.querySelector('input')?.dispatchEvent(new FocusEvent('focus'));
  const state = () => [panel.node.querySelectorAll('option').length, errorsOf(panel.node)];
  expect(await beforeAndAfter(state)).toEqual([
    [0, 1],
    [1, 0],
  ]);
});

test('a planned motion', async () => {
  vi.stubGlobal(
    'ResizeObserver',
    class {
      observe = vi.fn();
      disconnect = vi.fn();
    },
  );
  const motion = create(PlannedMotionSchema, { frameCount: 1, frameRateHz: 60 });
  const getFigure = lostOnce({ figure: { markerBones: [] } });
  const context = contextOf({
    clips: { listClips: () => Promise.resolve({ clips: [] }) },
    queries: { plan: () => Promise.resolve({ motion, alternatives: [], missing: '' }) },
    views: { getFigure },
  });
  const host = document.createElement('main');
  const query = new URLSearchParams('goal=2,1,0');
  const view = openPlan(host, context, { ...params, query });
  const state = () => [host.querySelectorAll('.overlay:not([hidden])').length, errorsOf(host)];
  expect(await beforeAndAfter(state)).toEqual([
    [0, 1],
    [0, 0],
  ]);
  expect(getFigure).toHaveBeenCalledTimes(2);
  view.close();
});
