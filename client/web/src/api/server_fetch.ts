// The calls of the page to its server, so that errors of the network differ from errors of the page.

// No server answered, or the connection broke. `fetch` reports this as a TypeError, which errors of
// the page itself are, too.
export class NoAnswerError extends Error {
  constructor(cause: TypeError) {
    super(cause.message, { cause });
    this.name = 'NoAnswerError';
  }
}

// A request body from this size is an upload.
const kUploadBytes = 1024 * 1024;
// An upload takes no longer than this, plus its size at a slow rate: `fetch` does not report how
// much is sent.
const kUploadMilliseconds = 30_000;
const kBytesPerMillisecond = 64;

// What passes between page and server. Calls share few connections and one uplink: a short call can
// wait for others although the server works.
export class Traffic {
  // When a part of an answer arrived, or an upload ended.
  private activeTime = -Infinity;
  // When each upload that runs should be answered at the latest.
  private readonly uploadEnds = new Set<{ time: number }>();

  // True if the server has answered since a time of performance.now(), or if a call that waits since
  // then can wait for an upload.
  explainsDelay(since: number): boolean {
    const now = performance.now();
    return this.activeTime >= since || [...this.uploadEnds].some(({ time }) => time > now);
  }

  // Call for each part of an answer.
  received(): void {
    this.activeTime = performance.now();
  }

  // A request with a body of this size begins. Returns the function to call at its answer or error.
  send(byteCount: number): () => void {
    if (byteCount < kUploadBytes) return () => undefined;
    const duration = kUploadMilliseconds + byteCount / kBytesPerMillisecond;
    const end = { time: performance.now() + duration };
    this.uploadEnds.add(end);
    return () => {
      this.uploadEnds.delete(end);
      this.activeTime = performance.now();
    };
  }
}

// `fetch` with NoAnswerError instead of TypeError, also while the body of the answer is read.
export async function fetchServer(
  input: RequestInfo | URL,
  init: RequestInit,
  traffic = new Traffic(),
): Promise<Response> {
  const end = traffic.send(sizeOf(init.body));
  const response = await fetch(input, init)
    .catch((error: unknown) => {
      throw withoutAnswer(error);
    })
    .finally(end);
  traffic.received();
  return response.body === null ? response : withBody(response, response.body, traffic);
}

function withBody(
  response: Response,
  body: ReadableStream<Uint8Array>,
  traffic: Traffic,
): Response {
  const reader = body.getReader();
  const { status, statusText, headers } = response;
  const stream = new ReadableStream<Uint8Array>(
    {
      async pull(controller) {
        try {
          const { done, value } = await reader.read();
          traffic.received();
          if (done) controller.close();
          else controller.enqueue(value);
        } catch (error) {
          controller.error(withoutAnswer(error));
        }
      },
      cancel: (reason) => reader.cancel(reason),
    },
    { highWaterMark: 0 },
  );
  return new Response(stream, { status, statusText, headers });
}

function withoutAnswer(error: unknown): unknown {
  return error instanceof TypeError ? new NoAnswerError(error) : error;
}

function sizeOf(body: BodyInit | null | undefined): number {
  if (body instanceof Blob) return body.size;
  if (body instanceof ArrayBuffer || ArrayBuffer.isView(body)) return body.byteLength;
  return 0;
}
