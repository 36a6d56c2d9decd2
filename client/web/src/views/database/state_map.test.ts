import { create } from '@bufbuild/protobuf';
import { describe, expect, it } from 'vitest';
import { ReadStateMapResponseSchema, type ReadStateMapResponse } from '../../api/messages';
import { floatBytes } from '../../motion/motion';
import { extentOf, StateMapReader } from './state_map';

function message(part: ReadStateMapResponse['part']): ReadStateMapResponse {
  return create(ReadStateMapResponseSchema, { part } as never);
}

const header = message({
  case: 'header',
  value: { layer: 3, nodeCount: 3, transitionCount: 2, pointCount: 1 } as never,
});

function nodes(ids: number[]): ReadStateMapResponse {
  const means = ids.flatMap((id) => [id, 2 * id, -id]);
  return message({
    case: 'nodes',
    value: {
      nodeIds: ids,
      parentIds: ids.map((id) => id >> 1),
      frameCounts: ids.map((id) => 10 * id),
      mainClips: ids.map(() => 0),
      labelFractions: ids.map(() => 1),
      means: floatBytes(Float32Array.from(means)),
      semiAxes: floatBytes(new Float32Array(9 * ids.length)),
    } as never,
  });
}

const transitions = message({
  case: 'transitions',
  value: { fromNodeIds: [4, 9], toNodeIds: [9, 5], probabilities: [0.5, 1] } as never,
});
const points = message({
  case: 'points',
  value: {
    clips: [0],
    frames: [7],
    nodeIds: [9],
    positions: floatBytes(Float32Array.of(1, 2, 30)),
  } as never,
});

describe('StateMapReader', () => {
  it('joins blocks and replaces node ids by places', () => {
    const reader = new StateMapReader();
    for (const part of [header, nodes([4, 5]), nodes([9]), transitions, points]) reader.add(part);
    const map = reader.finish();
    expect([...map.nodes.ids]).toEqual([4, 5, 9]);
    expect([...map.nodes.means]).toEqual([4, 8, -4, 5, 10, -5, 9, 18, -9]);
    expect([...map.transitions.from]).toEqual([0, 2]);
    expect([...map.transitions.to]).toEqual([2, 1]);
    expect([...map.points.nodes]).toEqual([2]);
    const extent = extentOf(map);
    expect(extent.centre).toEqual([5, 10, 10.5]);
    expect(extent.radius).toBeCloseTo(Math.hypot(4, 8, 19.5));
  });

  it('reports a stream that ends early or has no header', () => {
    const reader = new StateMapReader();
    expect(() => {
      reader.add(nodes([1]));
    }).toThrow(/header/);
    reader.add(header);
    reader.add(nodes([4]));
    expect(() => reader.finish()).toThrow(/expected 3 nodes, 2 transitions and 1 points, got 1/);
    expect(() => new StateMapReader().finish()).toThrow(/empty stream/);
  });
});
