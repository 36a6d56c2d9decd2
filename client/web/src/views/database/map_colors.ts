import { lastPart } from '../../api/resource_names';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { labelName, swatch } from '../../drawing/labels';
import { clipColor, LabelPalette, rgbOf, labelStyles } from '../../drawing/palette';
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

const kMaxLegendClips = 60;

// Colours and their meaning. A label is a button that hides its nodes and frames.
export class MapLegend {
  readonly node = element('div', { class: 'legend', role: 'group', 'aria-label': 'Legend' });

  constructor(private readonly toggle: (label: string) => void) {}

  show(
    map: StateMap,
    colorBy: 'label' | 'clip',
    hidden: readonly string[],
    theme: ThemeName,
  ): void {
    const { clips, labels } = map.header;
    const labelButtons = [...labelStyles(labels, theme)].map(([label, style]) => {
      const shown = !hidden.includes(label);
      const node = button(
        '',
        () => {
          this.toggle(label);
        },
        {
          'aria-pressed': shown ? 'true' : 'false',
          class: 'legend-label',
          'data-key': labelName(label),
        },
      );
      if (colorBy === 'label') node.append(swatch(style.color));
      node.append(labelName(label));
      return node;
    });
    const clipItems =
      colorBy === 'clip'
        ? clips.slice(0, kMaxLegendClips).map((clip, i) => {
            const name = element('span', { class: 'legend-clip' });
            name.append(swatch(clipColor(i, clips.length, theme)), lastPart(clip));
            return name;
          })
        : [];
    const rest =
      colorBy === 'clip' && clips.length > kMaxLegendClips
        ? element('span', { class: 'hint' }, `and ${clips.length - kMaxLegendClips} more clips`)
        : null;
    keepFocus(this.node, () => {
      replaceChildren(this.node, ...labelButtons, ...clipItems, rest);
    });
  }
}
