import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { expect, test, vi } from 'vitest';
import { Connection } from '../../api/connection';
import { ClipSchema } from '../../api/messages';
import type { ViewContext } from '../../shell/view';
import { open } from './clips_view';

vi.stubGlobal('CSS', { escape: (text: string) => text }); // jsdom has none
vi.stubGlobal(
  'IntersectionObserver',
  class {
    observe = vi.fn();
    unobserve = vi.fn();
    disconnect = vi.fn();
  },
);

test('the error of a deletion stays while the list is read again', async () => {
  const connection = new Connection(() => Promise.resolve());
  const clip = create(ClipSchema, { name: 'databases/demo/clips/a' });
  const list = { clips: [clip], totalCount: 1, nextPageToken: '', facets: [] };
  const listClips = vi.fn(() => Promise.resolve(list));
  const deleteClip = vi.fn(() => Promise.resolve({}));
  deleteClip.mockRejectedValueOnce(new ConnectError('disk full', Code.ResourceExhausted));
  const context = {
    api: {
      clips: { listClips, deleteClip },
      databases: { getDatabase: () => new Promise(() => undefined) },
      operations: { listOperations: () => Promise.resolve({ operations: [] }) },
    },
    connection,
    theme: { onChange: () => () => undefined },
    session: { role: 'ingester' },
    announce: vi.fn(),
  } as unknown as ViewContext;
  const host = document.createElement('main');
  document.body.replaceChildren(host);
  const view = open(host, context, { database: 'demo', path: [], query: new URLSearchParams() });
  const removeButton = () => host.querySelector<HTMLButtonElement>('[data-key="delete a"]')!;
  const errors = () =>
    [...host.querySelectorAll('.notice.error:not([hidden]) p')].map((node) => node.textContent);
  await vi.waitFor(() => {
    expect(removeButton()).not.toBeNull();
  });
  removeButton().click();
  removeButton().click();
  await vi.waitFor(() => {
    expect(errors()).toEqual(['disk full']);
  });
  const before = removeButton();
  connection.lose();
  connection.succeeded(); // reads the list again
  await vi.waitFor(() => {
    expect(removeButton()).not.toBe(before);
  });
  expect(errors()).toEqual(['disk full']);
  removeButton().click();
  removeButton().click();
  expect(errors()).toEqual([]);
  await vi.waitFor(() => {
    expect(listClips).toHaveBeenCalledTimes(3);
  });
  view.close();
  connection.close();
});
