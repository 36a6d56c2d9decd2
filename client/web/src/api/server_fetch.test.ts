import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { createApi } from './api';
import { describeError, isConnectionLost } from './errors';
import { DeleteDatabaseRequestSchema } from './messages';
import { fetchServer, NoAnswerError, Traffic } from './server_fetch';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

const failureOf = (call: Promise<unknown>) =>
  call.then(
    () => undefined,
    (error: unknown) => error,
  );
const observer = { succeeded: () => undefined, failed: () => undefined };
const apiOf = () => createApi('http://page.test', observer, new Traffic());

test('a call without an answer is a lost connection', async () => {
  vi.stubGlobal('fetch', () => Promise.reject(new TypeError('Failed to fetch')));
  const failure = await failureOf(apiOf().databases.listDatabases({}));
  expect(isConnectionLost(failure)).toBe(true);
  expect(describeError(failure)?.message).toBe('The server does not answer: Failed to fetch');
});

test('a connection that breaks in the body of an answer is lost', async () => {
  const headers = { 'content-type': 'application/proto' };
  vi.stubGlobal('fetch', () => {
    const body = new ReadableStream({
      pull: (controller) => {
        controller.error(new TypeError('network error'));
      },
    });
    return Promise.resolve(new Response(body, { headers }));
  });
  expect(isConnectionLost(await failureOf(apiOf().databases.listDatabases({})))).toBe(true);
  headers['content-type'] = 'application/connect+proto';
  const stream = apiOf().databases.watchDatabase({ name: 'databases/demo' });
  const failure = await failureOf(stream[Symbol.asyncIterator]().next());
  expect(isConnectionLost(failure)).toBe(true);
});

test('an error of the page in a call is not a lost connection', async () => {
  const fetch = vi.fn();
  vi.stubGlobal('fetch', fetch);
  const request = create(DeleteDatabaseRequestSchema);
  const fault = new TypeError('no property');
  Object.defineProperty(request, 'name', {
    get: () => {
      throw fault;
    },
  });
  const failure = await failureOf(apiOf().databases.deleteDatabase(request));
  expect(describeError(failure)?.message).toContain(fault.message);
  expect(isConnectionLost(failure)).toBe(false);
  expect(fetch).not.toHaveBeenCalled();
});

test('an aborted call stays one, and an answer arrives unchanged', async () => {
  const aborted = new DOMException('aborted', 'AbortError');
  vi.stubGlobal('fetch', () => Promise.reject(aborted));
  expect(await failureOf(fetchServer('/session', {}))).toBe(aborted);
  vi.stubGlobal('fetch', () =>
    Promise.resolve(new Response('text', { status: 409, headers: { etag: '7' } })),
  );
  const response = await fetchServer('/session', {});
  expect([response.status, response.headers.get('etag')]).toEqual([409, '7']);
  expect(await response.text()).toBe('text');
  expect(new NoAnswerError(new TypeError('no')).message).toBe('no');
});

test('a delay is explained by other answers, and by an upload for as long as it can take', async () => {
  let answer: (response: Response) => void = () => undefined;
  vi.stubGlobal('fetch', () => new Promise<Response>((resolve) => (answer = resolve)));
  const traffic = new Traffic();
  const small = fetchServer('/a', { method: 'POST', body: new Uint8Array(1000) }, traffic);
  await vi.advanceTimersByTimeAsync(100);
  const since = performance.now();
  expect(traffic.explainsDelay(since)).toBe(false);
  await vi.advanceTimersByTimeAsync(100);
  answer(new Response(null));
  await small;
  expect(traffic.explainsDelay(since)).toBe(true);
  await vi.advanceTimersByTimeAsync(100);
  expect(traffic.explainsDelay(performance.now())).toBe(false);

  // 6.4 MB take up to 30 + 100 s.
  const large = fetchServer('/b', { method: 'POST', body: new Uint8Array(6_400_000) }, traffic);
  await vi.advanceTimersByTimeAsync(129_000);
  expect(traffic.explainsDelay(performance.now())).toBe(true);
  await vi.advanceTimersByTimeAsync(2000);
  expect(traffic.explainsDelay(performance.now())).toBe(false);
  answer(new Response(null));
  await large;
});

test('an upload that is answered explains no delay any more', async () => {
  vi.stubGlobal('fetch', () => Promise.resolve(new Response(null)));
  const traffic = new Traffic();
  await fetchServer('/b', { method: 'POST', body: new Uint8Array(6_400_000) }, traffic);
  const since = performance.now();
  await vi.advanceTimersByTimeAsync(1);
  expect(traffic.explainsDelay(since)).toBe(true);
  expect(traffic.explainsDelay(performance.now())).toBe(false);
});
