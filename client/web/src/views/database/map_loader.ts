import type { Api } from '../../api/api';
import { NewestCall } from '../../api/newest_call';
import { clipName, modelName } from '../../api/resource_names';
import { StateMapReader, type StateMap } from './state_map';

export interface MapRequest {
  database: string;
  layer: number | undefined;
  // Id of a clip; empty: all nodes.
  clip: string;
  maxPoints: number;
}

// Reads a map of the current model. Returns `known`, another answer to the same request, if it is of
// that model. Rejects with the error of the call, or if the stream is not complete.
export async function loadMap(
  api: Api,
  request: MapRequest,
  signal: AbortSignal,
  known?: StateMap,
): Promise<StateMap> {
  const reader = new StateMapReader();
  const call = new NewestCall(signal);
  const { database, layer, clip, maxPoints } = request;
  const stream = api.views.readStateMap(
    {
      parent: modelName(database, 0),
      ...(layer === undefined ? {} : { layer }),
      clip: clip === '' ? '' : clipName(database, clip),
      maxPoints,
    },
    { signal: call.begin() },
  );
  for await (const message of stream) {
    reader.add(message);
    const { part } = message;
    // A model that is not stored has no number that tells it apart.
    if (known && part.case === 'header' && part.value.modelVersion !== 0) {
      if (part.value.modelVersion !== known.header.modelVersion) continue;
      call.stop();
      return known;
    }
  }
  return reader.finish();
}
