// Login of the browser: the server keeps the token in an HttpOnly cookie.

import { Code, ConnectError } from '@connectrpc/connect';
import { fetchServer } from './server_fetch';

// A server that hangs, or a dropped network, would otherwise not be noticed for minutes.
const kAnswerMilliseconds = 5000;

export type RoleName = 'reader' | 'ingester' | 'admin';

export interface Session {
  // False if the server needs no token.
  authenticationRequired: boolean;
  // Role of the caller; null without a login.
  role: RoleName | null;
  // The only database of the token, as an id; empty means all.
  database: string;
  // Caller as in the audit log, such as tokens/ab12; empty without authentication.
  principal: string;
  // Why the token of the browser is not valid; empty if it sent none.
  reason: string;
}

// Asks the server who the browser is.
export async function readSession(): Promise<Session> {
  const response = await request('GET', '/session');
  if (response.status === 401)
    return { authenticationRequired: true, role: null, database: '', principal: '', reason: '' };
  if (!response.ok) throw await failureOf(response);
  return parseSession(await response.json());
}

// Logs in with a token.
export async function logIn(token: string): Promise<void> {
  const response = await request('POST', '/login', JSON.stringify({ token }));
  if (!response.ok) throw await failureOf(response);
}

export async function logOut(): Promise<void> {
  const response = await request('POST', '/logout', '{}');
  if (!response.ok && response.status !== 401) throw await failureOf(response);
}

// The session in an answer of GET /session.
export function parseSession(value: unknown): Session {
  const fields = (value ?? {}) as Record<string, unknown>;
  const role = text(fields['role']).toLowerCase().replace('role_', '');
  return {
    authenticationRequired: fields['authenticationRequired'] === true,
    role: role === 'reader' || role === 'ingester' || role === 'admin' ? role : null,
    database: text(fields['database']).replace('databases/', ''),
    principal: text(fields['principal']),
    reason: text(fields['reason']),
  };
}

const kRoles: readonly RoleName[] = ['reader', 'ingester', 'admin'];

// True if the session includes the permissions of a role.
export function mayActAs(session: Session, role: RoleName): boolean {
  return session.role !== null && kRoles.indexOf(session.role) >= kRoles.indexOf(role);
}

function text(value: unknown): string {
  return typeof value === 'string' ? value : '';
}

function request(method: string, path: string, body?: string): Promise<Response> {
  return fetchServer(path, {
    method,
    credentials: 'same-origin',
    headers: body === undefined ? {} : { 'content-type': 'application/json' },
    body: body ?? null,
    signal: AbortSignal.timeout(kAnswerMilliseconds),
  });
}

// The error of an answer. An error of the server has a code; without one, a proxy answers for a
// server that it does not reach.
async function failureOf(response: Response): Promise<Error> {
  try {
    const body = (await response.json()) as { code?: unknown; message?: unknown };
    if (text(body.code) !== '' && text(body.message) !== '') return new Error(text(body.message));
  } catch {
    // The body is not JSON: the status says enough.
  }
  const failure = `expected a login, got HTTP status ${response.status}`;
  const isProxy = [502, 503, 504].includes(response.status);
  return isProxy ? new ConnectError(failure, Code.Unavailable) : new Error(failure);
}
