import { expect, test } from 'vitest';
import { mayActAs, parseSession } from './session';

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
  });
});

test('without a valid token there is no role', () => {
  expect(parseSession({ authenticationRequired: true, authenticated: false }).role).toBeNull();
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
