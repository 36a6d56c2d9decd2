import type { RecognitionWindow } from '../../api/messages';

// A window with the probabilities of labels.
export type LabelledWindow = Pick<
  RecognitionWindow,
  'startSeconds' | 'endSeconds' | 'labels' | 'familiarity'
> & { unknownProbability?: number | undefined };

// The most probable label of one window; unknown motion has an empty label and `unknown`.
export interface Winner {
  label: string;
  unknown: boolean;
  probability: number;
}

// A part of the ribbon: one label in one column. Times in s, heights 0 (bottom) to 1.
export interface RibbonArea extends Winner {
  startSeconds: number;
  endSeconds: number;
  bottom: number;
  top: number;
}

// Successive columns with the same most probable label.
export interface RibbonRun extends Winner {
  startSeconds: number;
  endSeconds: number;
}

// Areas below this probability are not drawn; the column shows the background there.
const kSmallestArea = 0.004;

// Time that each window stands for: the middle part between the middles of its neighbours. The
// first and the last column reach the ends of the motion that the windows cover.
export function columnsOf(windows: readonly LabelledWindow[]): [start: number, end: number][] {
  const middles = windows.map((window) => (window.startSeconds + window.endSeconds) / 2);
  return windows.map((window, i) => [
    i === 0 ? window.startSeconds : (middles[i - 1]! + middles[i]!) / 2,
    i === windows.length - 1 ? window.endSeconds : (middles[i]! + middles[i + 1]!) / 2,
  ]);
}

// The areas of a ribbon: in each column the probability of unknown motion at the bottom, then the
// labels in the order of `labels`, so that a label keeps its place from column to column.
export function ribbonAreas(
  windows: readonly LabelledWindow[],
  labels: readonly string[],
): RibbonArea[] {
  const places = new Map(labels.map((label, i) => [label, i]));
  return columnsOf(windows).flatMap(([startSeconds, endSeconds], i) => {
    const window = windows[i]!;
    const parts: Winner[] = window.labels
      .map(({ label, probability }) => ({ label, unknown: false, probability }))
      .sort((a, b) => (places.get(a.label) ?? Infinity) - (places.get(b.label) ?? Infinity));
    parts.unshift({ label: '', unknown: true, probability: window.unknownProbability ?? 0 });
    let bottom = 0;
    const areas: RibbonArea[] = [];
    for (const part of parts) {
      const top = Math.min(1, bottom + part.probability);
      if (part.probability >= kSmallestArea) {
        areas.push({ ...part, startSeconds, endSeconds, bottom, top });
      }
      bottom = top;
    }
    return areas;
  });
}

// The most probable label of a window, or unknown motion; undefined without labels.
export function winnerOf(window: LabelledWindow): Winner | undefined {
  const unknown = window.unknownProbability ?? 0;
  const [first] = window.labels;
  if (!first) return unknown > 0 ? { label: '', unknown: true, probability: unknown } : undefined;
  return unknown > first.probability
    ? { label: '', unknown: true, probability: unknown }
    : { label: first.label, unknown: false, probability: first.probability };
}

// Runs of columns with the same winner, with the mean probability of the winner.
export function runsOf(windows: readonly LabelledWindow[]): RibbonRun[] {
  const runs: (RibbonRun & { columns: number })[] = [];
  for (const [i, [startSeconds, endSeconds]] of columnsOf(windows).entries()) {
    const winner = winnerOf(windows[i]!);
    if (!winner) continue;
    const last = runs.at(-1);
    const continues =
      last?.label === winner.label &&
      last.unknown === winner.unknown &&
      last.endSeconds === startSeconds;
    if (last && continues) {
      last.endSeconds = endSeconds;
      last.probability =
        (last.probability * last.columns + winner.probability) / (last.columns + 1);
      ++last.columns;
    } else {
      runs.push({ ...winner, startSeconds, endSeconds, columns: 1 });
    }
  }
  return runs.map(({ label, unknown, probability, startSeconds, endSeconds }) => ({
    label,
    unknown,
    probability,
    startSeconds,
    endSeconds,
  }));
}

// Index of the window whose column contains a time; the nearest one outside; -1 without windows.
export function windowAt(windows: readonly LabelledWindow[], seconds: number): number {
  const columns = columnsOf(windows);
  const found = columns.findIndex(([, end]) => seconds < end);
  return found >= 0 ? found : columns.length - 1;
}
