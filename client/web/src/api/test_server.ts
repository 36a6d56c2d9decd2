import { create, toBinary } from '@bufbuild/protobuf';
import { ConnectError, type Code } from '@connectrpc/connect';
import { vi } from 'vitest';
import { ErrorInfoSchema } from './messages';

// An error as it arrives from a service of the server.
export function serverError(code: Code, reason: string) {
  const error = new ConnectError('from the test', code);
  const value = toBinary(ErrorInfoSchema, create(ErrorInfoSchema, { reason, domain: 'motiondb' }));
  error.details.push({ type: 'google.rpc.ErrorInfo', value });
  return error;
}

// A server of /session in place of fetch. `answer`: its answer; undefined: it hangs. Ends with
// vi.restoreAllMocks and vi.unstubAllGlobals.
export function stubServer(answer: () => Response | undefined) {
  // With the timers of the test.
  vi.spyOn(AbortSignal, 'timeout').mockImplementation((milliseconds) => {
    const ending = new AbortController();
    setTimeout(() => {
      ending.abort(new DOMException('signal timed out', 'TimeoutError'));
    }, milliseconds);
    return ending.signal;
  });
  const fetch = vi.fn(
    (_path: string, { signal }: RequestInit) =>
      new Promise<Response>((resolve, reject) => {
        const response = answer();
        if (response) resolve(response);
        signal?.addEventListener('abort', () => {
          reject(signal.reason as Error);
        });
      }),
  );
  vi.stubGlobal('fetch', fetch);
  return fetch;
}
