import { Code, ConnectError } from '@connectrpc/connect';
import type { Connection } from '../api/connection';
import { readSession, type Session } from '../api/session';
import { Disposer } from '../dom/disposer';
import { poll } from '../dom/poller';

const kCheckMilliseconds = 3000;

// Reads the session every 3 s while the page is visible: a view that makes no calls would not notice
// that the server is gone, or that the token is no longer valid. A lost connection has probes of its
// own. `present`: the session of the page.
export function checkSession(connection: Connection, present: () => Session): void {
  const check = async () => {
    if (connection.state !== 'connected') return;
    const before = present();
    try {
      const { authenticationRequired, role, reason } = await readSession();
      // The user can have logged in or out since.
      const isSame = before === present() && before.role !== null;
      if (isSame && authenticationRequired && role === null)
        connection.failed(new ConnectError(reason, Code.Unauthenticated));
    } catch (error) {
      connection.failed(error);
    }
  };
  // The page itself reads the session when it opens.
  setTimeout(() => {
    poll(new Disposer(), kCheckMilliseconds, check);
  }, kCheckMilliseconds);
}
