import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { describeError, isConnectionLost } from './errors';
import { logIn, mayActAs, parseSession, readSession } from './session';
import { stubServer } from './test_server';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

test('reads the answer of GET /session', () => {
  const session = parseSession({
    authenticationRequired: true,
    principal: 'tokens/ab',
    role: 'ingester',
    database: 'databases/demo',
  });
  expect(session).toEqual({
    authenticationRequired: true,
    principal: 'tokens/ab',
    role: 'ingester',
    database: 'demo',
    reason: '',
  });
});

test('without a valid token there is no role', () => {
  expect(parseSession({ authenticationRequired: true, authenticated: false }).role).toBeNull();
  const revoked = { authenticationRequired: true, authenticated: false, reason: 'it was revoked' };
  expect(parseSession(revoked)).toMatchObject({ role: null, reason: 'it was revoked' });
  expect(parseSession(null).role).toBeNull();
  expect(parseSession({ role: 'root' }).role).toBeNull();
});

test('a role includes the ones before it', () => {
  const session = parseSession({ role: 'ingester' });
  expect(mayActAs(session, 'reader')).toBe(true);
  expect(mayActAs(session, 'ingester')).toBe(true);
  expect(mayActAs(session, 'admin')).toBe(false);
  expect(mayActAs(parseSession({}), 'reader')).toBe(false);
});

const failureOf = (call: Promise<unknown>) =>
  call.then(
    () => undefined,
    (error: unknown) => error,
  );

test('a server that hangs is a lost connection, and the user sees it', async () => {
  stubServer(() => undefined);
  for (const call of [readSession, () => logIn('mdb_1')]) {
    const failure = failureOf(call());
    await vi.advanceTimersByTimeAsync(5000);
    expect(isConnectionLost(await failure)).toBe(true);
    expect(describeError(await failure)?.message).toContain('The server does not answer');
  }
});

test('a proxy that does not reach the server is a lost connection', async () => {
  for (const status of [502, 503, 504]) {
    for (const body of ['<h1>Bad gateway</h1>', '{"message":"no upstream"}']) {
      stubServer(() => new Response(body, { status }));
      expect(isConnectionLost(await failureOf(readSession()))).toBe(true);
    }
  }
});

test('an error of the server is no lost connection', async () => {
  const error = { code: 'unavailable', message: 'the store does not answer' };
  stubServer(() => Response.json(error, { status: 503 }));
  const failure = await failureOf(readSession());
  expect(isConnectionLost(failure)).toBe(false);
  expect(describeError(failure)?.message).toBe(error.message);
  stubServer(() => new Response('no', { status: 500 }));
  expect(isConnectionLost(await failureOf(readSession()))).toBe(false);
});
