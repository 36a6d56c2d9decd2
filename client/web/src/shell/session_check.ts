import { Code, ConnectError } from '@connectrpc/connect';
import type { Connection } from '../api/connection';
import type { Traffic } from '../api/server_fetch';
import { readSession, type Session } from '../api/session';
import { Disposer } from '../dom/disposer';
import { poll } from '../watch/waiting';

const kCheckMilliseconds = 3000;

export interface SessionCheckOptions {
  connection: Connection;
  // Of the other calls of the page.
  traffic: Traffic;
  // The session of the page.
  readonly present: () => Session;
  // The browser has another login, for example from another tab.
  readonly changed: () => void;
}

// Reads the session every 3 s while the page is visible: a view that makes no calls would not notice
// that the server is gone, or that the token is no longer valid. A lost connection has probes of its
// own. A read without an answer counts only if nothing else of the server arrives either.
export function checkSession({ connection, traffic, present, changed }: SessionCheckOptions): void {
  const check = async () => {
    const { state } = connection;
    if (state === 'lost') return;
    const before = present();
    const began = performance.now();
    try {
      const session = await readSession();
      // The user can have logged in or out since.
      if (before !== present() || state !== connection.state) return;
      const showsLogin = state === 'login' || before.role === null;
      if (session.role !== null) {
        if (showsLogin || !isSameLogin(before, session)) changed();
      } else if (session.authenticationRequired && !showsLogin) {
        connection.failed(new ConnectError(session.reason, Code.Unauthenticated));
      }
    } catch (error) {
      const isLate = error instanceof DOMException && error.name === 'TimeoutError';
      if (!isLate || !traffic.explainsDelay(began)) connection.failed(error);
    }
  };
  // The page itself reads the session when it opens.
  setTimeout(() => {
    poll(new Disposer(), kCheckMilliseconds, check);
  }, kCheckMilliseconds);
}

function isSameLogin(a: Session, b: Session): boolean {
  return a.principal === b.principal && a.role === b.role && a.database === b.database;
}
