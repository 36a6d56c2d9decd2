import { expect, test, vi } from 'vitest';
import type { Api } from './api';
import { pagesOf, readClipIds, readDatabaseIds } from './lists';

// Three pages of two items each.
function pagedApi() {
  const pageOf = (pageToken: string) => {
    const page = Number(pageToken);
    const items = [0, 1].map((i) => ({ name: `databases/demo/clips/${2 * page + i}` }));
    return { items, nextPageToken: page < 2 ? String(page + 1) : '' };
  };
  const list = vi.fn(({ pageToken }: { parent?: string; pageToken: string }) => {
    const { items, nextPageToken } = pageOf(pageToken);
    return Promise.resolve({ clips: items, databases: items, nextPageToken });
  });
  const api = { clips: { listClips: list }, databases: { listDatabases: list } };
  return { list, api: api as unknown as Api };
}

const all = ['0', '1', '2', '3', '4', '5'];

test('the names of all clips and databases are read, page by page', async () => {
  const { list, api } = pagedApi();
  const { signal } = new AbortController();
  expect(await readClipIds(api, 'demo', { signal })).toEqual(all);
  const request = { parent: 'databases/demo', pageSize: 1000, pageToken: '2' };
  expect(list).toHaveBeenLastCalledWith(request, { signal });
  expect(await readDatabaseIds(api)).toEqual(all);
  expect(list).toHaveBeenCalledTimes(6);
});

test('a page that cannot be read ends the list with its error', async () => {
  const read = vi
    .fn(() => Promise.reject<{ nextPageToken: string }>(new Error('gone')))
    .mockResolvedValueOnce({ nextPageToken: '1' });
  const pages = pagesOf(read);
  await pages.next();
  await expect(pages.next()).rejects.toThrow('gone');
  expect(read).toHaveBeenCalledTimes(2);
});
