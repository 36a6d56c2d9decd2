import { clipColor, LabelPalette, rgbOf } from '../../drawing/palette';
import type { ThemeName } from '../../shell/theme';
import type { StateMap } from './state_map';

export interface MapColors {
  nodeColors: Float32Array;
  pointColors: Float32Array;
  nodesShown: Uint8Array;
  pointsShown: Uint8Array;
}

// Colours of nodes (by the clip with most of their frames) and of points, and which of them are
// shown. Edges between nodes that are not shown are not drawn either.
export function mapColors(
  map: StateMap,
  colorBy: 'label' | 'clip',
  hiddenLabels: readonly string[],
  theme: ThemeName,
  palette = new LabelPalette(map.header.labels),
): MapColors {
  const { header, nodes, points } = map;
  const styles = palette.styles(theme);
  const hidden = new Set(hiddenLabels);
  const clipRgb = header.clips.map((_, clip) =>
    rgbOf(
      colorBy === 'clip'
        ? clipColor(clip, header.clips.length, theme)
        : (styles.get(header.labels[clip] ?? '')?.color ?? '#808080'),
    ),
  );
  const clipShown = header.clips.map((_, clip) => !hidden.has(header.labels[clip] ?? ''));
  const colorsOf = (clips: Int32Array) => {
    const colors = new Float32Array(3 * clips.length);
    clips.forEach((clip, i) => {
      colors.set(clipRgb[clip] ?? [0.5, 0.5, 0.5], 3 * i);
    });
    return colors;
  };
  const shownOf = (clips: Int32Array) =>
    Uint8Array.from(clips, (clip) => (clipShown[clip] === false ? 0 : 1));
  return {
    nodeColors: colorsOf(nodes.mainClips),
    pointColors: colorsOf(points.clips),
    nodesShown: shownOf(nodes.mainClips),
    pointsShown: shownOf(points.clips),
  };
}
