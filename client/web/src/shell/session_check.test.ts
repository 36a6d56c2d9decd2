import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Connection } from '../api/connection';
import { Traffic } from '../api/server_fetch';
import { parseSession, type Session } from '../api/session';
import { stubServer } from '../api/test_server';
import { setHidden } from '../watch/test_visibility';
import { checkSession } from './session_check';

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
  vi.restoreAllMocks();
  vi.unstubAllGlobals();
});

const admin = parseSession({ role: 'admin' });
const session = () => Response.json({ authenticationRequired: false, role: 'admin' });
// Begins the checks; returns what the other calls send and receive, and what a change calls.
function start(connection: Connection, present: () => Session) {
  const options = { traffic: new Traffic(), changed: vi.fn() };
  checkSession({ connection, present, ...options });
  return options;
}
const revoked = { authenticationRequired: true, reason: 'tokens/ab was revoked' };

test('a server that hangs is reported within a few seconds, by one check at a time', async () => {
  let hangs = false;
  const fetch = stubServer(() => (hangs ? undefined : session()));
  const connection = new Connection(() => new Promise(() => undefined));
  start(connection, () => admin);
  expect(fetch).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(6000);
  expect([connection.state, fetch.mock.calls.length]).toEqual(['connected', 2]);
  hangs = true;
  await vi.advanceTimersByTimeAsync(3000 + 4900);
  expect([connection.state, fetch.mock.calls.length]).toEqual(['connected', 3]);
  await vi.advanceTimersByTimeAsync(100);
  expect(connection.state).toBe('lost');
  // The connection asks by itself until the server answers.
  await vi.advanceTimersByTimeAsync(30_000);
  expect(fetch).toHaveBeenCalledTimes(3);
});

test('a hidden page does not ask', async () => {
  const fetch = stubServer(session);
  setHidden(true);
  start(new Connection(() => Promise.resolve()), () => admin);
  await vi.advanceTimersByTimeAsync(10_000);
  expect(fetch).not.toHaveBeenCalled();
  setHidden(false);
  await vi.advanceTimersByTimeAsync(3000);
  expect(fetch).toHaveBeenCalledTimes(1);
});

test('a token that is revoked asks for a login, with the reason', async () => {
  stubServer(() => Response.json(revoked));
  const connection = new Connection(() => Promise.resolve());
  start(connection, () => admin);
  await vi.advanceTimersByTimeAsync(3000);
  expect([connection.state, connection.loginReason]).toEqual(['login', 'tokens/ab was revoked']);
});

test('the form of the login stays, and an answer from before a login counts for nothing', async () => {
  let answer: (response: Response) => void = () => undefined;
  vi.stubGlobal('fetch', () => new Promise<Response>((resolve) => (answer = resolve)));
  const connection = new Connection(() => Promise.resolve());
  let present = parseSession(revoked);
  start(connection, () => present);
  await vi.advanceTimersByTimeAsync(3000);
  answer(Response.json(revoked));
  await vi.advanceTimersByTimeAsync(3000);
  present = admin;
  answer(Response.json(revoked));
  await vi.advanceTimersByTimeAsync(100);
  expect(connection.state).toBe('connected');
});

test('a server without authentication needs no login', async () => {
  const fetch = stubServer(() => Response.json({ authenticationRequired: false }));
  const connection = new Connection(() => Promise.resolve());
  start(connection, () => admin);
  await vi.advanceTimersByTimeAsync(9000);
  expect([connection.state, fetch.mock.calls.length]).toEqual(['connected', 3]);
});

test('another login of the browser restarts the page', async () => {
  const login = {
    authenticationRequired: true,
    principal: 'tokens/1',
    role: 'admin',
    database: '',
  };
  const present = parseSession(login);
  let answer: object = login;
  stubServer(() => Response.json(answer));
  const connection = new Connection(() => Promise.resolve());
  const { changed } = start(connection, () => present);
  await vi.advanceTimersByTimeAsync(6000);
  expect(changed).not.toHaveBeenCalled();
  const others = [{ principal: 'tokens/2' }, { role: 'reader' }, { database: 'databases/demo' }];
  for (const [i, other] of others.entries()) {
    answer = { ...login, ...other };
    await vi.advanceTimersByTimeAsync(3000);
    expect(changed).toHaveBeenCalledTimes(i + 1);
  }
  expect(connection.state).toBe('connected');
});

test('a login in another tab ends the form of the login', async () => {
  let answer: object = revoked;
  stubServer(() => Response.json(answer));
  const connection = new Connection(() => Promise.resolve());
  let present = admin;
  const { changed } = start(connection, () => present);
  await vi.advanceTimersByTimeAsync(6000);
  expect([connection.state, changed.mock.calls.length]).toEqual(['login', 0]);
  answer = { authenticationRequired: true, principal: 'tokens/2', role: 'reader' };
  await vi.advanceTimersByTimeAsync(3000);
  expect(changed).toHaveBeenCalledTimes(1);
  present = parseSession(answer);
  connection.succeeded();
  await vi.advanceTimersByTimeAsync(6000);
  expect(changed).toHaveBeenCalledTimes(1);
  // A page that opened without a login.
  present = parseSession(revoked);
  await vi.advanceTimersByTimeAsync(3000);
  expect(changed).toHaveBeenCalledTimes(2);
});

test('a check that waits behind an upload or other answers is not a lost connection', async () => {
  stubServer(() => undefined);
  const connection = new Connection(() => new Promise(() => undefined));
  const { traffic } = start(connection, () => admin);
  const answered = traffic.send(50e6);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(connection.state).toBe('connected');
  answered();
  const arriving = setInterval(() => {
    traffic.received();
  }, 4000);
  await vi.advanceTimersByTimeAsync(60_000);
  expect(connection.state).toBe('connected');
  clearInterval(arriving);
  await vi.advanceTimersByTimeAsync(16_000);
  expect(connection.state).toBe('lost');
});

test('a server that refuses connections is lost, also during an upload', async () => {
  vi.stubGlobal('fetch', () => Promise.reject(new TypeError('Failed to fetch')));
  const connection = new Connection(() => new Promise(() => undefined));
  start(connection, () => admin).traffic.send(50e6);
  await vi.advanceTimersByTimeAsync(3000);
  expect(connection.state).toBe('lost');
});
