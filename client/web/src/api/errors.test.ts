import { Code, ConnectError } from '@connectrpc/connect';
import { expect, test } from 'vitest';
import { describeError, isConnectionLost } from './errors';
import { NoAnswerError } from './server_fetch';
import { serverError } from './test_server';

test('a server that answers that it cannot do something is not lost', () => {
  for (const reason of ['UNAVAILABLE', 'STORE_UNREACHABLE']) {
    const error = serverError(Code.Unavailable, reason);
    expect(isConnectionLost(error)).toBe(false);
    expect(describeError(error)).toMatchObject({ message: 'from the test', reason });
  }
});

test('a server that stops, and one that does not answer, are lost', () => {
  const refused = new ConnectError(
    'fetch failed',
    Code.Unknown,
    undefined,
    undefined,
    new NoAnswerError(new TypeError()),
  );
  const proxy = new ConnectError('HTTP 502', Code.Unavailable);
  for (const error of [serverError(Code.Unavailable, 'SERVER_STOPPING'), proxy, refused]) {
    expect(isConnectionLost(error)).toBe(true);
    expect(describeError(error)?.message).toMatch(/^The server does not answer: /);
  }
});

test('an error of the page itself is not a lost connection', () => {
  const error = new TypeError('cannot read properties of undefined');
  for (const each of [error, ConnectError.from(error), ConnectError.from(error, Code.Internal)]) {
    expect(isConnectionLost(each)).toBe(false);
    expect(describeError(each)?.message).toBe(error.message);
  }
});
