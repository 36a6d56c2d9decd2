import { Code, ConnectError } from '@connectrpc/connect';
import { BadRequestSchema, ErrorInfoSchema, RequestInfoSchema } from './messages';
import { fromBinary } from '@bufbuild/protobuf';

// An error of a call, for the user.
export interface DescribedError {
  message: string;
  code: Code;
  // Reason for a program, as in docs/api.md; empty if the error has none.
  reason: string;
  metadata: Record<string, string>;
  // Path of the invalid field; empty if no field is named.
  field: string;
  requestId: string;
}

// Describes an error; undefined for a call that the page itself aborted.
export function describeError(error: unknown): DescribedError | undefined {
  const failure = ConnectError.from(error);
  if (
    failure.code === Code.Canceled ||
    (error instanceof DOMException && error.name === 'AbortError')
  )
    return undefined;
  const described: DescribedError = {
    message: failure.rawMessage,
    code: failure.code,
    reason: '',
    metadata: {},
    field: '',
    requestId: '',
  };
  for (const detail of failure.details) {
    if (!('type' in detail)) continue;
    const type = detail.type.slice(detail.type.lastIndexOf('.') + 1);
    if (type === 'ErrorInfo') {
      const info = fromBinary(ErrorInfoSchema, detail.value);
      described.reason = info.reason;
      described.metadata = info.metadata;
    } else if (type === 'RequestInfo') {
      described.requestId = fromBinary(RequestInfoSchema, detail.value).requestId;
    } else if (type === 'BadRequest') {
      described.field = fromBinary(BadRequestSchema, detail.value).fieldViolations[0]?.field ?? '';
    }
  }
  if (failure.code === Code.Unimplemented)
    described.message =
      'The server does not have this function, because it is older than this page. ' +
      `Update motiondbd, then load the page again. (${failure.rawMessage})`;
  if (isConnectionLost(error))
    described.message = `The server does not answer: ${failure.rawMessage}`;
  return described;
}

export function hasCode(error: unknown, ...codes: Code[]): boolean {
  return error instanceof ConnectError && codes.includes(error.code);
}

// True if no server answered. fetch reports that as a TypeError, which Connect wraps.
export function isConnectionLost(error: unknown): boolean {
  if (error instanceof TypeError) return true;
  return (
    error instanceof ConnectError &&
    (error.code === Code.Unavailable ||
      (error.code === Code.Unknown && error.cause instanceof TypeError) ||
      (error.code === Code.Internal && error.cause instanceof TypeError))
  );
}
