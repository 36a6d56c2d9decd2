import type { Api } from '../../api/api';
import { NewestCall } from '../../api/connection';
import type { ReadStateMapResponse, StateMapHeader } from '../../api/messages';
import { clipName, modelName } from '../../api/resource_names';
import { floatsOf } from '../../motion/motion';

// Nodes of a layer, in order of node id. Arrays of vectors have 3 values for each node.
export interface MapNodes {
  ids: Int32Array;
  // -1 for the root.
  parents: Int32Array;
  frameCounts: Int32Array;
  mainClips: Int32Array;
  labelFractions: Float32Array;
  // Means in the first three principal axes.
  means: Float32Array;
  // 9 values for each node: three semi-axes as rows, longest first.
  semiAxes: Float32Array;
}

// Transitions, as indices in `MapNodes` (not node ids).
export interface MapTransitions {
  from: Int32Array;
  to: Int32Array;
  probabilities: Float32Array;
}

// Frames as points.
export interface MapPoints {
  clips: Int32Array;
  frames: Int32Array;
  // Indices in `MapNodes`; -1 for a node that is not in the map.
  nodes: Int32Array;
  positions: Float32Array;
}

// One layer of a model in the principal axes, as the server sent it.
export interface StateMap {
  header: StateMapHeader;
  nodes: MapNodes;
  transitions: MapTransitions;
  points: MapPoints;
}

// Collects the messages of `ReadStateMap`.
export class StateMapReader {
  private map: StateMap | undefined;
  private nodeCount = 0;
  private transitionCount = 0;
  private pointCount = 0;
  private indexOfId = new Map<number, number>();

  // Adds the next message. Throws if the stream does not begin with a header or is too long.
  add(message: ReadStateMapResponse): void {
    const { part } = message;
    if (part.case === 'header') {
      this.map = emptyMap(part.value);
      return;
    }
    const map = this.map;
    if (!map) throw new Error('expected the header of a state map first');
    if (part.case === 'nodes') {
      const { nodes } = map;
      const at = this.nodeCount;
      const value = part.value;
      nodes.ids.set(value.nodeIds, at);
      nodes.parents.set(value.parentIds, at);
      nodes.frameCounts.set(value.frameCounts, at);
      nodes.mainClips.set(value.mainClips, at);
      nodes.labelFractions.set(value.labelFractions, at);
      nodes.means.set(floatsOf(value.means), 3 * at);
      nodes.semiAxes.set(floatsOf(value.semiAxes), 9 * at);
      value.nodeIds.forEach((id, i) => this.indexOfId.set(id, at + i));
      this.nodeCount += value.nodeIds.length;
    } else if (part.case === 'transitions') {
      const at = this.transitionCount;
      const value = part.value;
      map.transitions.from.set(value.fromNodeIds.map(this.indexOf), at);
      map.transitions.to.set(value.toNodeIds.map(this.indexOf), at);
      map.transitions.probabilities.set(value.probabilities, at);
      this.transitionCount += value.fromNodeIds.length;
    } else if (part.case === 'points') {
      const at = this.pointCount;
      const value = part.value;
      map.points.clips.set(value.clips, at);
      map.points.frames.set(value.frames, at);
      map.points.nodes.set(value.nodeIds.map(this.indexOf), at);
      map.points.positions.set(floatsOf(value.positions), 3 * at);
      this.pointCount += value.clips.length;
    }
  }

  // The complete map. Throws if the stream ended early.
  finish(): StateMap {
    const map = this.map;
    if (!map) throw new Error('expected the header of a state map, got an empty stream');
    const { header } = map;
    if (
      this.nodeCount !== header.nodeCount ||
      this.transitionCount !== header.transitionCount ||
      this.pointCount !== header.pointCount
    ) {
      throw new Error(
        `expected ${header.nodeCount} nodes, ${header.transitionCount} transitions and ` +
          `${header.pointCount} points, got ${this.nodeCount}, ${this.transitionCount} and ` +
          `${this.pointCount}: load the map again`,
      );
    }
    return map;
  }

  private indexOf = (id: number): number => this.indexOfId.get(id) ?? -1;
}

// Half the diagonal and the centre of the box around the means of all nodes and points.
export function extentOf(map: StateMap): { centre: [number, number, number]; radius: number } {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const values of [map.nodes.means, map.points.positions]) {
    for (let i = 0; i < values.length; ++i) {
      low[i % 3] = Math.min(low[i % 3]!, values[i]!);
      high[i % 3] = Math.max(high[i % 3]!, values[i]!);
    }
  }
  if (low[0] === Infinity) return { centre: [0, 0, 0], radius: 1 };
  const centre = low.map((value, i) => (value + high[i]!) / 2) as [number, number, number];
  const radius = Math.hypot(...low.map((value, i) => (high[i]! - value) / 2));
  return { centre, radius: Math.max(radius, 1e-3) };
}

function emptyMap(header: StateMapHeader): StateMap {
  const { nodeCount, transitionCount, pointCount } = header;
  return {
    header,
    nodes: {
      ids: new Int32Array(nodeCount),
      parents: new Int32Array(nodeCount).fill(-1),
      frameCounts: new Int32Array(nodeCount),
      mainClips: new Int32Array(nodeCount),
      labelFractions: new Float32Array(nodeCount),
      means: new Float32Array(3 * nodeCount),
      semiAxes: new Float32Array(9 * nodeCount),
    },
    transitions: {
      from: new Int32Array(transitionCount),
      to: new Int32Array(transitionCount),
      probabilities: new Float32Array(transitionCount),
    },
    points: {
      clips: new Int32Array(pointCount),
      frames: new Int32Array(pointCount),
      nodes: new Int32Array(pointCount),
      positions: new Float32Array(3 * pointCount),
    },
  };
}

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
