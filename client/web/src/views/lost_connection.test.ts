// Panels read again what failed when the connection was lost.
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from '../api/connection';
import { Disposer } from '../dom/disposer';
import { PlaybackClock } from '../player/playback_clock';
import type { ViewContext } from '../shell/view';
import { BackupPanel } from './admin/backup_panel';
import { ComparePanel } from './clip/compare_panel';
import type { MotionPane } from './clip/motion_pane';
import { NodePanel } from './database/node_panel';
import { NodePoses } from './database/node_poses';
import type { StateMap } from './database/state_map';
import { open as openPlan } from './plan/plan_view';
import { ProfilePanel } from './query/profile_panel';

vi.mock('./query/profile_chart', () => ({
  ProfileChart: class {
    node = document.createElement('figure');
    dispose() {
      this.node.remove();
    }
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
  const context = { api, connection, theme, setQuery: vi.fn(), announce: vi.fn() };
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
  const panel = new ProfilePanel(contextOf({ queries: { recognize } }), vi.fn(), vi.fn());
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
  const motion = {
    frameCount: 1,
    frameRateHz: 60,
    markerNames: [],
    markerPositions: new Uint8Array(),
    jointNames: [],
    jointBones: [],
    jointVisuals: [],
    jointPositions: new Uint8Array(),
    jointRotations: new Uint8Array(),
    root: [],
    segments: [],
  };
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
