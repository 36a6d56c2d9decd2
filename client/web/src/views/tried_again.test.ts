// What failed and is tried again, by the user and when the connection is restored, happens once.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from '../api/connection';
import { ClipSchema } from '../api/messages';
import { Disposer } from '../dom/disposer';
import { PlaybackClock } from '../player/playback_clock';
import type { ViewContext } from '../shell/view';
import { AuditPanel } from './admin/audit_panel';
import { open as openClip } from './clip/clip_view';
import { ComparePanel } from './clip/compare_panel';
import { MotionPane } from './clip/motion_pane';

// No chart, and no WebGL.
vi.mock('./clip/curve_panel', () => ({}));
vi.mock('../scene/scene', () => ({ createScene: () => undefined }));

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

// A server that can be stopped, and a page in front of it.
function openPage() {
  const server = { up: true };
  const connection = new Connection(
    () => (server.up ? Promise.resolve() : Promise.reject(new TypeError('down'))),
    1000,
  );
  const answer = <Response>(response: Response) =>
    vi.fn(async () => {
      await new Promise((resolve) => setTimeout(resolve, 10));
      if (!server.up) throw new ConnectError('gone', Code.Unavailable);
      connection.succeeded();
      return response;
    });
  const clip = create(ClipSchema, { name: 'databases/demo/clips/a' });
  const audit = { entries: [{ sequence: 1n, code: 0 }], nextPageToken: '' };
  const api = {
    clips: { getClip: answer({ clip }) },
    access: { listAuditEntries: answer(audit) },
    databases: { getDatabase: answer({ database: {} }) },
  };
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000' };
  const motions = { load: vi.fn((): Promise<void> => new Promise(() => undefined)) };
  const session = { authenticationRequired: false };
  const context = { api, connection, theme, motions, session };
  const silent = { setQuery: vi.fn(), announce: vi.fn(), setTitle: vi.fn() };
  return { server, api, motions, context: { ...context, ...silent } as unknown as ViewContext };
}

const params = { database: 'demo', path: ['a'], query: new URLSearchParams() };

function press(node: Element, text: string) {
  const found = [...node.querySelectorAll('button')].find((each) => each.textContent === text);
  if (!found) throw new Error(`no button ${text}`);
  found.click();
}

test('a clip opens once', async () => {
  const { server, api, context } = openPage();
  server.up = false;
  const host = document.createElement('main');
  const view = openClip(host, context, params);
  for (let attempt = 0; attempt < 2; ++attempt) {
    await vi.advanceTimersByTimeAsync(20);
    press(host, 'Try again');
  }
  await vi.advanceTimersByTimeAsync(20);
  server.up = true;
  press(host, 'Try again'); // before the page knows that the server answers
  await vi.advanceTimersByTimeAsync(5000);
  // Four attempts, and one call when the watch of the database begins.
  expect(api.clips.getClip).toHaveBeenCalledTimes(5);
  expect(host.querySelectorAll('.motion-pane').length).toBe(1);
  expect(host.querySelectorAll('.notice.error:not([hidden])').length).toBe(0);
  view.close();
});

test('a motion is loaded once', async () => {
  const { server, motions, context } = openPage();
  const lost = () => Promise.reject(new ConnectError('gone', Code.Unavailable));
  motions.load.mockImplementation(lost);
  server.up = false;
  const ends = new AbortController();
  const events = { started: vi.fn(), completed: vi.fn() };
  const pane = new MotionPane(context, 'a', 'etag', 'a', [], ends.signal, events);
  void pane.load();
  for (let attempt = 0; attempt < 2; ++attempt) {
    await vi.advanceTimersByTimeAsync(20);
    press(pane.node, 'Try again');
  }
  await vi.advanceTimersByTimeAsync(20);
  expect(motions.load).toHaveBeenCalledTimes(3);
  motions.load.mockImplementation(() => Promise.resolve());
  server.up = true;
  await vi.advanceTimersByTimeAsync(5000);
  expect(motions.load).toHaveBeenCalledTimes(4);
  expect(events.completed).toHaveBeenCalledTimes(1);
  ends.abort();
});

test('entries of the audit log are listed once', async () => {
  const { server, context } = openPage();
  const panel = new AuditPanel(context, new Disposer());
  await vi.advanceTimersByTimeAsync(20);
  const rows = () => panel.node.querySelectorAll('tbody tr').length;
  expect(rows()).toBe(1);
  press(panel.node, 'Refresh');
  press(panel.node, 'Refresh');
  await vi.advanceTimersByTimeAsync(20);
  expect(rows()).toBe(1);
  server.up = false;
  for (let attempt = 0; attempt < 3; ++attempt) {
    press(panel.node, 'Refresh');
    await vi.advanceTimersByTimeAsync(20);
  }
  server.up = true;
  await vi.advanceTimersByTimeAsync(5000);
  expect(rows()).toBe(1);
});

test('quick changes of the second clip open one', async () => {
  const { context } = openPage();
  const stages = document.createElement('div');
  const first = { stage: { has: () => false } } as unknown as MotionPane;
  const clock = new PlaybackClock(1, 60);
  const panel = new ComparePanel(context, params, clock, new Disposer(), stages, first);
  const input = panel.node.querySelector('input')!;
  for (const id of ['b', 'c', 'b']) {
    input.value = id;
    input.dispatchEvent(new Event('change'));
  }
  await vi.advanceTimersByTimeAsync(1000);
  expect([...stages.querySelectorAll('h2')].map((title) => title.textContent)).toEqual(['b']);
  expect(stages.className).toBe('pair');
});
