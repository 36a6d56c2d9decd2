// Lists of choices have the items of all pages.
import { expect, test, vi } from 'vitest';
import { Disposer } from '../dom/disposer';
import { PlaybackClock } from '../player/playback_clock';
import type { ViewContext } from '../shell/view';
import { BackupPanel } from './admin/backup_panel';
import { ComparePanel } from './clip/compare_panel';
import type { MotionPane } from './clip/motion_pane';

// No WebGL.
vi.mock('../scene/scene', () => ({ createScene: () => undefined }));

// Two pages, each with one item.
const list = ({ pageToken }: { pageToken?: string }) => {
  const items = [{ name: `databases/demo/clips/${pageToken ? 'second' : 'first'}` }];
  return Promise.resolve({ clips: items, databases: items, nextPageToken: pageToken ? '' : 'n' });
};
const api = { clips: { listClips: list }, databases: { listDatabases: list } };
const context = { api } as unknown as ViewContext;

const choicesIn = (node: HTMLElement) =>
  [...node.querySelectorAll('option')].map((option) => option.value);

test('databases to download', async () => {
  const { node } = new BackupPanel(context, new Disposer(), false);
  await vi.waitFor(() => {
    expect(choicesIn(node)).toEqual(['first', 'second']);
  });
});

test('clips to compare with', async () => {
  const params = { database: 'demo', path: [], query: new URLSearchParams() };
  const { node } = new ComparePanel(
    context,
    params,
    new PlaybackClock(1, 60),
    new Disposer(),
    document.createElement('div'),
    {} as MotionPane,
  );
  node.querySelector('input')?.dispatchEvent(new FocusEvent('focus'));
  await vi.waitFor(() => {
    expect(choicesIn(node)).toEqual(['first', 'second']);
  });
});
