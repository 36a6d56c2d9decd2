import type { RecognitionWindow } from '../../api/messages';

// Generation probability of one clip over time (Figs. 13 to 15).
export interface ClipProfile {
  clip: string;
  label: string;
  // Natural logarithm for each window; null if the window does not rank the clip or allows no path.
  logProbabilities: (number | null)[];
}

// Profiles of all clips at one layer.
export interface Profile {
  layer: number;
  // Middle of each window, s.
  times: number[];
  // In order of label, then clip.
  clips: ClipProfile[];
}

type ProfileWindow = Pick<RecognitionWindow, 'startSeconds' | 'endSeconds' | 'layer' | 'clips'>;

// Arranges the windows of an answer as one line for each clip.
export function profileOf(windows: readonly ProfileWindow[]): Profile {
  const profiles = new Map<string, ClipProfile>();
  windows.forEach((window, at) => {
    for (const { clip, label, logProbability } of window.clips) {
      let profile = profiles.get(clip);
      if (!profile) {
        const logProbabilities = new Array<number | null>(windows.length).fill(null);
        profiles.set(clip, (profile = { clip, label, logProbabilities }));
      }
      profile.logProbabilities[at] = Number.isFinite(logProbability) ? logProbability : null;
    }
  });
  const clips = [...profiles.values()].sort(
    (a, b) => compare(a.label, b.label) || compare(a.clip, b.clip),
  );
  return {
    layer: windows[0]?.layer ?? 0,
    times: windows.map((window) => (window.startSeconds + window.endSeconds) / 2),
    clips,
  };
}

// Smallest and largest value over all clips; undefined if there is none.
export function rangeOf(profile: Profile): [number, number] | undefined {
  let low = Infinity;
  let high = -Infinity;
  for (const { logProbabilities } of profile.clips) {
    for (const value of logProbabilities) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return low <= high ? [low, high] : undefined;
}

// Layers to compare by default: the bottom, about 3/5 and 2/5 of the depth, as in the paper.
export function comparedLayers(layerCount: number): number[] {
  const layers = [layerCount, Math.round(layerCount * 0.6), Math.round(layerCount * 0.4)];
  return [...new Set(layers.filter((layer) => layer >= 1))];
}

function compare(a: string, b: string): number {
  return a < b ? -1 : a > b ? 1 : 0;
}
