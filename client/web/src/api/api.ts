import { createClient, type Client, type Interceptor } from '@connectrpc/connect';
import { createConnectTransport } from '@connectrpc/connect-web';
import * as messages from './messages';
import { fetchServer, type Traffic } from './server_fetch';

// Typed clients of all services that a browser can call.
export interface Api {
  access: Client<typeof messages.AccessService>;
  clips: Client<typeof messages.ClipService>;
  databases: Client<typeof messages.DatabaseService>;
  edits: Client<typeof messages.EditService>;
  markerSets: Client<typeof messages.MarkerSetService>;
  models: Client<typeof messages.ModelService>;
  observe: Client<typeof messages.ObserveService>;
  operations: Client<typeof messages.OperationService>;
  queries: Client<typeof messages.QueryService>;
  segments: Client<typeof messages.SegmentService>;
  server: Client<typeof messages.ServerService>;
  store: Client<typeof messages.StoreService>;
  views: Client<typeof messages.ViewService>;
}

// Outcome of each call, for the state of the connection and the login.
export interface CallObserver {
  succeeded(): void;
  failed(error: unknown): void;
}

// Clients that call the server that served the page, in binary format. `traffic` gets what they send
// and receive.
export function createApi(baseUrl: string, observer: CallObserver, traffic: Traffic): Api {
  const observe: Interceptor = (next) => async (request) => {
    try {
      const response = await next(request);
      observer.succeeded();
      return response;
    } catch (error) {
      observer.failed(error);
      throw error;
    }
  };
  const transport = createConnectTransport({
    baseUrl,
    useBinaryFormat: true,
    interceptors: [observe],
    fetch: (input, init) =>
      fetchServer(input, { ...init, credentials: 'same-origin', redirect: 'error' }, traffic),
  });
  return {
    access: createClient(messages.AccessService, transport),
    clips: createClient(messages.ClipService, transport),
    databases: createClient(messages.DatabaseService, transport),
    edits: createClient(messages.EditService, transport),
    markerSets: createClient(messages.MarkerSetService, transport),
    models: createClient(messages.ModelService, transport),
    observe: createClient(messages.ObserveService, transport),
    operations: createClient(messages.OperationService, transport),
    queries: createClient(messages.QueryService, transport),
    segments: createClient(messages.SegmentService, transport),
    server: createClient(messages.ServerService, transport),
    store: createClient(messages.StoreService, transport),
    views: createClient(messages.ViewService, transport),
  };
}
