import { describe, expect, it } from 'vitest';
import { comparedLayers, profileOf, rangeOf } from './profile_series';

function window(at: number, ...clips: [clip: string, label: string, logProbability: number][]) {
  return {
    startSeconds: at,
    endSeconds: at + 0.4,
    layer: 7,
    clips: clips.map(([clip, label, logProbability]) => ({ clip, label, logProbability })),
  } as never;
}

describe('profileOf', () => {
  const profile = profileOf([
    window(0, ['b', 'walk', -10], ['a', 'walk', -20], ['c', 'jump', -Infinity]),
    window(0.1, ['a', 'walk', -12], ['c', 'jump', -30]),
  ]);

  it('has one line for each clip, in order of label', () => {
    expect(profile.layer).toBe(7);
    expect(profile.times).toEqual([0.2, 0.3]);
    expect(profile.clips.map(({ clip }) => clip)).toEqual(['c', 'a', 'b']);
    expect(profile.clips.map((clip) => clip.logProbabilities)).toEqual([
      [null, -30],
      [-20, -12],
      [-10, null],
    ]);
  });

  it('has the range of the finite values', () => {
    expect(rangeOf(profile)).toEqual([-30, -10]);
    expect(rangeOf(profileOf([]))).toBeUndefined();
  });
});

describe('comparedLayers', () => {
  it('are the layers of Fig. 13 for a tree of 17 layers', () => {
    expect(comparedLayers(17)).toEqual([17, 10, 7]);
    expect(comparedLayers(1)).toEqual([1]);
  });
});
