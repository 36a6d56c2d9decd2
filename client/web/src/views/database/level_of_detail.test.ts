import { describe, expect, it } from 'vitest';
import { indicesOfLargest, largestNodes, strongestTransitions } from './level_of_detail';
import type { MapNodes } from './state_map';

function nodesAt(means: number[], lengths: number[]): MapNodes {
  const count = lengths.length;
  const semiAxes = new Float32Array(9 * count);
  lengths.forEach((length, i) => {
    semiAxes[9 * i] = length;
  });
  return {
    ids: Int32Array.from({ length: count }, (_, i) => i),
    parents: new Int32Array(count),
    frameCounts: new Int32Array(count),
    mainClips: new Int32Array(count),
    labelFractions: new Float32Array(count),
    means: Float32Array.from(means),
    semiAxes,
  };
}

const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1];

describe('indicesOfLargest', () => {
  it('is the sorted head of the list for any values and budget', () => {
    let seed = 7;
    const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
    for (let round = 0; round < 200; ++round) {
      const values = Float32Array.from({ length: 1 + Math.floor(random() * 30) }, () =>
        Math.max(0, Math.floor(random() * 6) - 1),
      );
      const budget = Math.floor(random() * 32);
      const expected = [...values.keys()]
        .filter((i) => values[i]! > 0)
        .sort((a, b) => values[b]! - values[a]! || a - b)
        .slice(0, budget)
        .sort((a, b) => a - b);
      expect([...indicesOfLargest(values, budget)]).toEqual(expected);
    }
  });

  it('selects from 100,000 values', () => {
    const values = Float32Array.from({ length: 100_000 }, (_, i) => (i * 7919) % 100_003);
    expect(indicesOfLargest(values, 3000)).toHaveLength(3000);
  });
});

describe('largestNodes', () => {
  it('leaves out nodes outside the view and small ones', () => {
    const nodes = nodesAt([0, 0, 0, 5, 0, 0, 0.5, 0, 0, 0, 0.5, 0], [0.1, 9, 0.3, 0.2]);
    expect([...largestNodes(nodes, identity, 2)]).toEqual([2, 3]);
  });
});

describe('strongestTransitions', () => {
  it('leaves out loops, unknown nodes and improbable transitions', () => {
    const transitions = {
      from: Int32Array.of(0, 0, 1, -1, 2),
      to: Int32Array.of(0, 1, 2, 2, 0),
      probabilities: Float32Array.of(0.9, 0.1, 0.6, 1, 0.02),
    };
    expect([...strongestTransitions(transitions)]).toEqual([1, 2, 4]);
    expect([...strongestTransitions(transitions, 0.1)]).toEqual([1, 2]);
    expect([...strongestTransitions(transitions, 0, 1)]).toEqual([2]);
  });
});
