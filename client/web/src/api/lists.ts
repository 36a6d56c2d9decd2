import type { CallOptions } from '@connectrpc/connect';
import type { Api } from './api';
import { DatabaseView } from './messages';
import { databaseName, lastPart } from './resource_names';

// The most that the server permits.
const kPageSize = 1000;

interface ListRequest {
  pageSize: number;
  pageToken: string;
}

// Yields all pages of a list.
export async function* pagesOf<Page extends { nextPageToken: string }>(
  read: (request: ListRequest) => Promise<Page>,
): AsyncGenerator<Page> {
  let pageToken = '';
  do {
    const page = await read({ pageSize: kPageSize, pageToken });
    yield page;
    pageToken = page.nextPageToken;
  } while (pageToken);
}

// The ids of all resources of a list.
async function idsOf<Page extends { nextPageToken: string }>(
  read: (request: ListRequest) => Promise<Page>,
  listed: (page: Page) => readonly { name: string }[],
): Promise<string[]> {
  const ids: string[] = [];
  for await (const page of pagesOf(read))
    ids.push(...listed(page).map(({ name }) => lastPart(name)));
  return ids;
}

export function readDatabaseIds(api: Api, options: CallOptions = {}): Promise<string[]> {
  return idsOf(
    (request) => api.databases.listDatabases(request, options),
    ({ databases }) => databases,
  );
}

export function readClipIds(api: Api, database: string, options: CallOptions): Promise<string[]> {
  const parent = databaseName(database);
  return idsOf(
    (request) => api.clips.listClips({ ...request, parent }, options),
    ({ clips }) => clips,
  );
}

// The labels of the stored motion of a database.
export async function readLabels(
  api: Api,
  database: string,
  signal: AbortSignal,
): Promise<string[]> {
  const name = databaseName(database);
  const response = await api.databases.getDatabase({ name, view: DatabaseView.FULL }, { signal });
  return (response.database?.statistics?.labels ?? []).map(({ label }) => label);
}
