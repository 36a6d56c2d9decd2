// Maps of states without a server and without pictures, for unit tests.
import { vi } from 'vitest';
import { floatBytes } from '../../motion/motion';

// Stands for the parts of a browser that jsdom lacks; the test file replaces createScene itself.
export function stubDrawing(): void {
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(null);
  vi.stubGlobal(
    'ResizeObserver',
    class {
      observe = vi.fn();
      disconnect = vi.fn();
    },
  );
}

// The answer to ReadStateMap: the header of layer 2, then its nodes, each behind the one before.
// `sendsNodes` is called before the nodes.
export async function* stateMapOf(
  modelVersion: number,
  nodeIds: readonly number[],
  sendsNodes: () => void = () => undefined,
) {
  const count = nodeIds.length;
  const header = { modelVersion, layer: 2, nodesPerLayer: [1, count] };
  const counts = { nodeCount: count, transitionCount: 0, pointCount: 0 };
  const lists = { labels: ['walk'], clips: ['databases/demo/clips/a'], varianceFractions: [1] };
  yield { part: { case: 'header', value: { ...header, ...lists, ...counts } } };
  await Promise.resolve();
  sendsNodes();
  const nodes = {
    nodeIds,
    parentIds: nodeIds.map(() => 1),
    frameCounts: nodeIds.map((_, i) => 20 - 5 * i),
    labelFractions: nodeIds.map(() => 1),
    mainClips: nodeIds.map(() => 0),
    means: floatBytes(Float32Array.from({ length: 3 * count }, (_, i) => Math.floor(i / 3))),
    semiAxes: floatBytes(new Float32Array(9 * count)),
  };
  yield { part: { case: 'nodes', value: nodes } };
}
