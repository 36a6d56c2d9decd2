import type { Api } from '../../api/api';
import { clipName, currentModelName } from '../../api/resource_names';
import { StateMapReader, type StateMap } from './state_map';

export interface MapRequest {
  database: string;
  layer: number | undefined;
  // Id of a clip; empty: all nodes.
  clip: string;
  maxPoints: number;
}

// Reads a map. Rejects with the error of the call, or if the stream is not complete.
export async function loadMap(
  api: Api,
  request: MapRequest,
  signal: AbortSignal,
): Promise<StateMap> {
  const reader = new StateMapReader();
  const { database, layer, clip, maxPoints } = request;
  const stream = api.views.readStateMap(
    {
      parent: currentModelName(database),
      ...(layer === undefined ? {} : { layer }),
      clip: clip === '' ? '' : clipName(database, clip),
      maxPoints,
    },
    { signal },
  );
  for await (const message of stream) reader.add(message);
  return reader.finish();
}
