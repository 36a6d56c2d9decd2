import type { Api } from '../../api/api';
import { element } from '../../dom/element';
import { legendEntries } from '../../drawing/labels';
import type { LabelPalette } from '../../drawing/palette';
import type { ThemeSwitch } from '../../shell/theme';
import { loadMap, type StateMap } from '../database/state_map';
import { MapPanel } from '../database/map_panel';
import { describeNode } from '../database/node_panel';
import type { MomentAnswer } from './prediction';

const kPathContent = {
  axes: '123',
  colorBy: 'label',
  hiddenLabels: [],
  leastProbability: 0.05,
  size: 0.3,
} as const;

// The estimated node path on the map of states, with the most probable next node, as in Fig. 11.
export class PathMap {
  readonly node = element('section', { class: 'path-map', 'aria-label': 'Path', hidden: true });
  private readonly text = element('p', { class: 'hint' });
  private readonly legend = element('div', { class: 'legend' });
  private panel: MapPanel | undefined;
  private map: StateMap | undefined;

  constructor(
    private readonly api: Api,
    private readonly theme: ThemeSwitch,
    private readonly database: string,
    private readonly palette: LabelPalette,
  ) {}

  async show({ estimate, prediction }: MomentAnswer, signal: AbortSignal): Promise<void> {
    const { layer, modelVersion } = estimate;
    const request = { database: this.database, layer, clip: '', maxPoints: 10_000 };
    const known = this.map?.header.layer === layer ? this.map : undefined;
    const map = await loadMap(this.api, request, signal, known);
    this.map = map;
    // 0: not stored yet.
    if (map.header.modelVersion !== 0 && map.header.modelVersion !== modelVersion)
      throw new Error('The model was built again: predict again to see the path of nodes.');
    this.node.hidden = false;
    const places = new Map(Array.from(map.nodes.ids, (id, place) => [id, place]));
    const ids = estimate.paths[0]?.nodeIds ?? [];
    const path = withoutRepeats(ids.flatMap((id) => places.get(id) ?? []));
    const next = places.get(prediction.nextNodes[0]?.nodeId ?? -1);
    const nodes = new Map(path.map((place) => [place, '--path']));
    if (next !== undefined) nodes.set(next, '--next');
    const { palette } = this;
    palette.add(map.header.labels);
    this.openPanel().show({ map, ...kPathContent, palette }, { nodes, path });
    this.drawLegend();
    this.text.textContent = `Path: ${path.map((place) => map.nodes.ids[place]!).join(', ')}`;
  }

  // Also called after a change of the theme.
  drawLegend(): void {
    const styles = this.palette.styles(this.theme.name);
    this.legend.replaceChildren(...legendEntries(this.map?.header.labels ?? [], styles));
  }

  hide(): void {
    this.node.hidden = true;
  }

  close(): void {
    this.panel?.close();
  }

  private openPanel(): MapPanel {
    if (this.panel) return this.panel;
    const describe = (place: number) => {
      if (this.map && place >= 0) this.text.textContent = describeNode(this.map, place);
    };
    const label = 'Estimated path in principal axes. Arrow keys turn, + and - zoom.';
    this.panel = new MapPanel({ theme: this.theme, label, onPoint: describe, onChoose: describe });
    this.node.append(this.panel.node, this.legend, this.text);
    this.panel.open(null);
    return this.panel;
  }
}

// A path without the frames that stay in a node.
export function withoutRepeats(path: readonly number[]): number[] {
  return path.filter((node, i) => node !== path[i - 1]);
}
