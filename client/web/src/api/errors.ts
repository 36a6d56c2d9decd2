import { Code, ConnectError } from '@connectrpc/connect';
import { BadRequestSchema, ErrorInfoSchema, RequestInfoSchema } from './messages';
import { fromBinary } from '@bufbuild/protobuf';
import { NoAnswerError } from './server_fetch';

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
  const isLost = isConnectionLost(error);
  if (
    !isLost &&
    (failure.code === Code.Canceled ||
      (error instanceof DOMException && error.name === 'AbortError'))
  )
    return undefined;
  const described: DescribedError = {
    message: failure.rawMessage,
    code: failure.code,
    ...detailsOf(failure),
  };
  if (failure.code === Code.Unimplemented)
    described.message =
      'The server does not have this function, because it is older than this page. ' +
      `Update motiondbd, then load the page again. (${failure.rawMessage})`;
  if (isLost) described.message = `The server does not answer: ${failure.rawMessage}`;
  return described;
}

function detailsOf(failure: ConnectError): Omit<DescribedError, 'message' | 'code'> {
  const details = { reason: '', metadata: {}, field: '', requestId: '' };
  for (const detail of failure.details) {
    if (!('type' in detail)) continue;
    const type = detail.type.slice(detail.type.lastIndexOf('.') + 1);
    if (type === 'ErrorInfo') {
      const info = fromBinary(ErrorInfoSchema, detail.value);
      details.reason = info.reason;
      details.metadata = info.metadata;
    } else if (type === 'RequestInfo') {
      details.requestId = fromBinary(RequestInfoSchema, detail.value).requestId;
    } else if (type === 'BadRequest') {
      details.field = fromBinary(BadRequestSchema, detail.value).fieldViolations[0]?.field ?? '';
    }
  }
  return details;
}

export function hasCode(error: unknown, ...codes: Code[]): boolean {
  return error instanceof ConnectError && codes.includes(error.code);
}

// True if no server answered, or if it stops. fetchServer reports that as a NoAnswerError, which
// Connect wraps, or as the end of its time limit. Each error of a service of the server has a reason.
export function isConnectionLost(error: unknown): boolean {
  if (error instanceof NoAnswerError) return true;
  if (error instanceof DOMException && error.name === 'TimeoutError') return true;
  if (!(error instanceof ConnectError)) return false;
  if (error.code === Code.Unavailable)
    return ['', 'SERVER_STOPPING'].includes(detailsOf(error).reason);
  return hasCode(error, Code.Unknown, Code.Internal) && error.cause instanceof NoAnswerError;
}
