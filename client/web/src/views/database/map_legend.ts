import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { labelName, swatch } from '../../drawing/legend';
import { clipColor, labelStyles } from '../../drawing/palette';
import { lastPart } from '../../api/resource_names';
import type { ThemeName } from '../../shell/theme';
import type { StateMap } from './state_map';

const kMaxClips = 60;

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
        ? clips.slice(0, kMaxClips).map((clip, i) => {
            const name = element('span', { class: 'legend-clip' });
            name.append(swatch(clipColor(i, clips.length, theme)), lastPart(clip));
            return name;
          })
        : [];
    const rest =
      colorBy === 'clip' && clips.length > kMaxClips
        ? element('span', { class: 'hint' }, `and ${clips.length - kMaxClips} more clips`)
        : null;
    keepFocus(this.node, () => {
      replaceChildren(this.node, ...labelButtons, ...clipItems, rest);
    });
  }
}
