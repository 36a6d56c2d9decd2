// A clip that is replaced while it is open.
import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { Connection } from '../../api/connection';
import { ClipSchema, type Clip } from '../../api/messages';
import type { ViewContext } from '../../shell/view';
import { open } from './clip_view';

// No chart, and no WebGL.
vi.mock('./curve_panel', () => ({}));
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

const kName = 'databases/demo/clips/a';
const version = (etag: string, created: bigint, edited: bigint) =>
  create(ClipSchema, {
    name: kName,
    etag,
    createTime: { seconds: created },
    updateTime: { seconds: edited },
  });

// A page that shows a clip, with a function that stores another version of it.
async function openPage() {
  const server: { clip: Clip; tell: () => void } = {
    clip: version('1', 1n, 1n),
    tell: () => undefined,
  };
  const getClip = vi.fn(() => Promise.resolve({ clip: server.clip }));
  async function* watchDatabase() {
    for (let revision = 2n; ; ++revision) {
      await new Promise<void>((resolve) => (server.tell = resolve));
      yield { revision, upToDate: true, change: { case: 'clip', value: server.clip } };
    }
  }
  const load = vi.fn(() => new Promise(() => undefined));
  const query = new URLSearchParams();
  const context = {
    api: {
      clips: { getClip },
      databases: { getDatabase: () => Promise.resolve({ database: {} }), watchDatabase },
    },
    connection: new Connection(() => Promise.resolve()),
    theme: { name: 'light', onChange: () => () => undefined, color: () => '#000' },
    motions: { load },
    session: { role: 'reader' },
    setQuery: vi.fn(),
    setTitle: vi.fn(),
    announce: vi.fn(),
  };
  const host = document.createElement('main');
  const view = open(host, context as unknown as ViewContext, {
    database: 'demo',
    path: ['a'],
    query,
  });
  await vi.waitFor(() => {
    expect(getClip).toHaveBeenCalledTimes(2); // also when the watch begins
  });
  const store = async (clip: Clip) => {
    server.clip = clip;
    server.tell();
    await new Promise((resolve) => setTimeout(resolve));
  };
  const loadButton = () =>
    [...host.querySelectorAll('button')].find((each) => each.textContent === 'Load the new motion');
  return { host, view, store, load, loadButton, query };
}

test('a replaced clip says so and is opened again', async () => {
  const { host, view, store, load, loadButton, query } = await openPage();
  await store(version('2', 1n, 2n));
  expect(loadButton()).toBeUndefined();
  await store(version('3', 3n, 2n));
  expect(load.mock.calls.map((call: unknown[]) => call[1])).toEqual(['1']);
  query.set('speed', '2'); // of the address, which has changed since
  loadButton()!.click();
  await vi.waitFor(() => {
    expect(load.mock.calls.map((call: unknown[]) => call[1])).toEqual(['1', '3']);
  });
  expect(loadButton()).toBeUndefined();
  expect(host.querySelectorAll('.motion-pane').length).toBe(1);
  expect(host.querySelector<HTMLSelectElement>('.player select')?.value).toBe('2');
  await store(version('4', 3n, 2n));
  expect(loadButton()).toBeDefined();
  view.close();
});
