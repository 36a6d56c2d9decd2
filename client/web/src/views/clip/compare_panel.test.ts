// A second clip that changes while it is open.
import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { expect, test, vi } from 'vitest';
import { Connection } from '../../api/connection';
import { ClipSchema, type WatchDatabaseResponse } from '../../api/messages';
import { Disposer } from '../../dom/disposer';
import { PlaybackClock } from '../../player/playback_clock';
import type { ViewContext } from '../../shell/view';
import { ComparePanel } from './compare_panel';
import type { MotionPane } from './motion_pane';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

const version = (etag: string, edited: bigint, name = 'b') =>
  create(ClipSchema, {
    name: `databases/demo/clips/${name}`,
    etag,
    createTime: { seconds: 1n },
    updateTime: { seconds: edited },
  });
type Change = WatchDatabaseResponse['change'];

async function openPanel() {
  const getClip = vi.fn(() => Promise.resolve({ clip: version('1', 1n) }));
  const load = vi.fn(() => new Promise(() => undefined));
  const context = {
    api: { clips: { getClip } },
    connection: new Connection(() => Promise.resolve()),
    theme: { name: 'light', onChange: () => () => undefined, color: () => '#000' },
    motions: { load },
    setQuery: vi.fn(),
  };
  const disposer = new Disposer();
  const panel = new ComparePanel(
    context as unknown as ViewContext,
    { database: 'demo', path: ['a'], query: new URLSearchParams('with=b') },
    new PlaybackClock(1, 60),
    disposer,
    document.createElement('div'),
    { stage: { has: () => false } } as unknown as MotionPane,
  );
  const loads = (etags: string[]) =>
    vi.waitFor(() => {
      expect(load.mock.calls.map((call: unknown[]) => call[1])).toEqual(etags);
    });
  await loads(['1']);
  const follow = (change: Change) => {
    panel.follow([{ change } as WatchDatabaseResponse]);
  };
  const loadButton = () =>
    [...panel.node.querySelectorAll('button')].find(({ textContent }) =>
      textContent.startsWith('Load the new motion'),
    );
  return { panel, getClip, loads, follow, loadButton, disposer };
}

test('a second clip that is derived again offers its new motion', async () => {
  const { getClip, loads, follow, loadButton, disposer } = await openPanel();
  follow({ case: 'clip', value: version('2', 2n) }); // an edit
  follow({ case: 'clip', value: version('9', 1n, 'other') });
  expect(loadButton()).toBeUndefined();
  follow({ case: 'clip', value: version('3', 2n) });
  await loads(['1']);
  getClip.mockResolvedValue({ clip: version('3', 2n) });
  loadButton()!.click();
  await loads(['1', '3']);
  expect(loadButton()).toBeUndefined();
  disposer.dispose();
});

test('a second clip whose changes were missed is read again', async () => {
  const { panel, getClip, loadButton, disposer } = await openPanel();
  getClip.mockResolvedValue({ clip: version('2', 1n) });
  panel.follow([]);
  await vi.waitFor(() => {
    expect(loadButton()).toBeDefined();
  });
  getClip.mockRejectedValue(new ConnectError('no clip', Code.NotFound));
  panel.follow([]);
  await vi.waitFor(() => {
    expect(panel.node.textContent).toContain('Another client has deleted the second clip.');
  });
  disposer.dispose();
});
