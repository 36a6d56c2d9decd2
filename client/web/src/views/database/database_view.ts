import './database.css';
import { DatabaseView } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { Disposer } from '../../dom/disposer';
import { element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { percent } from '../../dom/format';
import { Notice } from '../../dom/notice';
import type { View, ViewContext, ViewParams } from '../../shell/view';
import { watchDatabase, WatchNotice } from '../../watch/database_watch';
import { AxisEnds, NodePoses } from './node_poses';
import { labelTable, layerTable, propertiesTable } from './database_table';
import { MapControls } from './map_controls';
import { MapLegend } from './map_colors';
import { loadMap, type StateMap } from './state_map';
import { MapPanel } from './map_panel';
import { queryOf, settingsOf, type MapSettings } from './map_settings';
import { NodeList } from './node_list';
import { describeNode, NodePanel, showOldModel, showPoseError } from './node_panel';

const kMaxPoints = 20_000;

// The view of a database and its model: the map of states (Figs. 6 to 10) and Table I.
export function open(host: HTMLElement, context: ViewContext, params: ViewParams): View {
  const view = new DatabasePage(host, context, params);
  view.start();
  return view;
}

class DatabasePage implements View {
  private readonly disposer = new Disposer();
  private readonly notice = new Notice();
  private readonly watchNotice: WatchNotice;
  private readonly poses: NodePoses;
  private readonly panel: MapPanel;
  private readonly controls: MapControls;
  private readonly legend: MapLegend;
  private readonly nodePanel: NodePanel;
  private readonly axisEnds: AxisEnds;
  private readonly nodeList: NodeList;
  private readonly variance = element('p', { class: 'hint' });
  // Everything of the map.
  private readonly answer = element('div');
  private readonly tables = element('section', {
    class: 'panel tables',
    'aria-label': 'Statistics',
  });
  private readonly layers = element('div');
  private settings: MapSettings;
  private map: StateMap | undefined;
  private loading = new AbortController();

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
  ) {
    this.settings = settingsOf(params.query);
    this.watchNotice = new WatchNotice(context.connection);
    this.poses = new NodePoses(context.api, params.database, this.disposer.signal);
    this.controls = new MapControls(this.settings, (changes) => {
      this.change(changes);
    });
    this.legend = new MapLegend((label) => {
      const { hiddenLabels } = this.settings;
      const hidden = hiddenLabels.includes(label)
        ? hiddenLabels.filter((other) => other !== label)
        : [...hiddenLabels, label];
      this.change({ hiddenLabels: hidden });
    });
    this.nodePanel = new NodePanel(this.poses, context.connection, () => void this.load());
    this.axisEnds = new AxisEnds(this.poses);
    this.nodeList = new NodeList((node) => {
      this.choose(node);
    });
    this.panel = new MapPanel({
      theme: context.theme,
      label:
        'States in principal axes. Keys: arrows turn, Shift and arrows move, + and - zoom, ' +
        '[ and ] change the layer.',
      onPoint: (node) => {
        if (this.map && node >= 0) this.nodePanel.show(this.map, node);
      },
      onChoose: (node) => {
        this.choose(node);
      },
      onCamera: (camera) => {
        context.setQuery({ camera });
      },
    });
    const side = element(
      'div',
      { class: 'map-side stack' },
      this.nodePanel.node,
      this.axisEnds.node,
    );
    host.append(
      element('h1', {}, `Database ${params.database}`),
      this.notice.node,
      this.watchNotice.node,
      this.controls.node,
      this.answer,
      this.tables,
    );
    this.answer.append(
      element('div', { class: 'map-layout' }, this.panel.node, side),
      this.variance,
      this.legend.node,
      this.nodeList.node,
    );
    this.disposer.listen<'keydown'>(this.panel.node, 'keydown', (event) => {
      if (event.key === '[') this.controls.stepLayer(-1);
      else if (event.key === ']') this.controls.stepLayer(1);
    });
    this.disposer.add(
      context.theme.onChange(() => {
        this.drawLegend();
      }),
    );
  }

  start(): void {
    this.panel.open(this.params.query.get('camera'));
    void this.load();
    void this.loadStatistics();
    void this.watchModel();
  }

  close(): void {
    this.disposer.dispose();
    this.loading.abort();
    this.nodePanel.close();
    this.panel.close();
  }

  private change(changes: Partial<MapSettings>): void {
    const before = this.settings;
    this.settings = { ...before, ...changes };
    const other = ['layer', 'clip', 'points'] as const;
    const reload = other.some((name) => this.settings[name] !== before[name]);
    if (reload) {
      this.settings.node = undefined;
      this.nodePanel.clear();
    }
    this.context.setQuery(queryOf(this.settings));
    if (this.settings.axes !== before.axes) this.context.setQuery({ camera: null });
    if (reload) void this.load();
    else this.draw();
  }

  private async load(): Promise<void> {
    this.loading.abort();
    this.loading = new AbortController();
    const { signal } = this.loading;
    const { layer, clip, points } = this.settings;
    const request = { database: this.params.database, layer, clip };
    try {
      this.panel.node.setAttribute('aria-busy', 'true');
      const maxPoints = points ? kMaxPoints : 0;
      const map = await loadMap(this.context.api, { ...request, maxPoints }, signal);
      if (this.map && this.map.header.modelVersion !== map.header.modelVersion) {
        this.forgetNode();
        void this.loadStatistics();
      }
      this.map = map;
      this.notice.clear();
      this.answer.hidden = false;
      this.draw();
      this.context.announce(
        `Layer ${map.header.layer}: ${map.header.nodeCount} nodes, ` +
          `${map.header.transitionCount} transitions`,
      );
    } catch (error) {
      if (!signal.aborted) {
        this.notice.error(error);
        this.answer.hidden = true; // it is of the settings before
      }
      this.context.connection.whenRestored(error, signal, () => void this.load());
    } finally {
      if (!signal.aborted) this.panel.node.removeAttribute('aria-busy');
    }
  }

  // Says when another model than that of the map is the current one.
  private async watchModel(): Promise<void> {
    await watchDatabase(this.context.api, {
      database: this.params.database,
      signal: this.disposer.signal,
      observer: this.watchNotice,
      changed: (changes) => {
        const shown = this.map?.header.modelVersion;
        const isOther = changes.some(
          ({ change }) => change.case === 'modelVersion' && change.value !== shown,
        );
        if (!isOther || shown === undefined) return;
        showOldModel(this.notice, () => void this.load());
        void this.loadStatistics();
      },
    });
  }

  // The ids of nodes are those of one model.
  private forgetNode(): void {
    this.nodePanel.clear();
    this.settings.node = undefined;
    this.context.setQuery(queryOf(this.settings));
  }

  private draw(): void {
    const { map, settings } = this;
    if (!map) return;
    this.drawMap(map);
    this.controls.show(map);
    this.nodeList.show(map);
    this.drawLegend();
    this.drawLayers(map);
    const parts = map.header.varianceFractions.map((part, i) => `${i + 1}: ${percent(part)}`);
    this.variance.textContent = `Variance along the principal axes: ${parts.join(', ')}`;
    this.axisEnds.show(map, settings.axes).catch((error: unknown) => {
      showPoseError(this.notice, error, () => void this.load());
      this.context.connection.whenRestored(error, this.disposer.signal, () => void this.load());
    });
  }

  private drawMap(map: StateMap): void {
    const { axes, colorBy, hiddenLabels, leastProbability, size, node } = this.settings;
    const chosen = node === undefined ? -1 : map.nodes.ids.indexOf(node);
    const nodes = new Map(chosen >= 0 ? [[chosen, '--path']] : []);
    this.panel.show(
      { map, axes, colorBy, hiddenLabels, leastProbability, size },
      { nodes, path: [] },
    );
    if (chosen >= 0) this.nodePanel.show(map, chosen);
  }

  private drawLegend(): void {
    const { colorBy, hiddenLabels } = this.settings;
    if (this.map) this.legend.show(this.map, colorBy, hiddenLabels, this.context.theme.name);
  }

  private drawLayers({ header }: StateMap): void {
    keepFocus(this.layers, () => {
      replaceChildren(
        this.layers,
        layerTable(header.nodesPerLayer, header.layer, (layer) => {
          this.change({ layer });
        }),
      );
    });
  }

  private choose(node: number): void {
    const { map } = this;
    if (!map) return;
    this.settings = { ...this.settings, node: map.nodes.ids[node]! };
    this.context.setQuery(queryOf(this.settings));
    this.drawMap(map);
    this.context.announce(describeNode(map, node));
  }

  private async loadStatistics(): Promise<void> {
    const notice = new Notice();
    replaceChildren(this.tables, notice.node);
    try {
      const response = await this.context.api.databases.getDatabase(
        { name: databaseName(this.params.database), view: DatabaseView.FULL },
        { signal: this.disposer.signal },
      );
      const statistics = response.database?.statistics;
      if (statistics) {
        replaceChildren(
          this.tables,
          propertiesTable(statistics),
          this.layers,
          labelTable(statistics),
        );
      }
    } catch (error) {
      notice.error(error);
      this.context.connection.whenRestored(error, this.disposer.signal, () => {
        void this.loadStatistics();
      });
    }
  }
}
