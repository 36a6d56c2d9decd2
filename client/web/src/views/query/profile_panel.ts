import { Method } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { button, element, labelled } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { legendEntries } from '../../drawing/labels';
import type { LabelPalette } from '../../drawing/palette';
import type { ViewContext } from '../../shell/view';
import { observationOf, type ObservedMotion } from './observed_motion';
import { ProfileChart } from './profile_chart';
import { comparedLayers, profileOf, type Profile } from './profile_series';

// What is asked for profiles.
export interface ProfileQuestion {
  database: string;
  observed: ObservedMotion;
  filter: string;
  window: number;
  // Empty: bottom, middle and upper layer.
  layers: readonly number[];
  // Called with the layers that are shown.
  chosen: (layers: number[]) => void;
}

// Generation probability over time for several layers, one chart for each.
export class ProfilePanel {
  readonly node = element('section', {
    class: 'panel stack',
    'aria-label': 'Generation probability',
  });
  private readonly layers = element('input', { placeholder: 'bottom, middle, upper' });
  private readonly legend = element('div', { class: 'legend' });
  private readonly charts = element('div', { class: 'profiles' });
  private readonly notice = new Notice();
  private drawn: ProfileChart[] = [];
  private profiles: Profile[] = [];
  private seconds = 0;
  private loading = new AbortController();
  private readonly removeTheme: () => void;

  constructor(
    private readonly context: Pick<ViewContext, 'api' | 'connection' | 'theme'>,
    private readonly palette: LabelPalette,
    private readonly seek: (seconds: number) => void,
    private readonly ask: (layers: number[]) => void,
  ) {
    const start = button('Show generation probability', () => {
      const layers = this.layers.value.split(/[ ,]+/).map(Number);
      this.ask(layers.filter((layer) => Number.isInteger(layer) && layer >= 1));
    });
    this.node.append(
      element('h2', {}, 'Generation probability by layer'),
      element('div', { class: 'row' }, labelled('Layers', this.layers), start),
      this.notice.node,
      this.legend,
      this.charts,
    );
    this.removeTheme = context.theme.onChange(() => {
      this.draw();
    });
  }

  // Asks one query for each layer.
  async load(question: ProfileQuestion): Promise<void> {
    this.clear();
    const { signal } = this.loading;
    try {
      const layers = await this.layersOf(question, signal);
      this.layers.value = layers.join(', ');
      question.chosen(layers);
      this.notice.message('Computing the probabilities of all clips ...');
      for (const layer of layers) {
        const response = await this.context.api.queries.recognize(
          {
            database: databaseName(question.database),
            observation: observationOf(question.observed),
            windowSeconds: question.window,
            layer,
            method: Method.PAPER,
            filter: question.filter,
          },
          { signal },
        );
        this.profiles.push(profileOf(response.windows));
        this.draw();
      }
      this.notice.clear();
    } catch (error) {
      if (!signal.aborted) this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => void this.load(question));
    }
  }

  // Removes charts of another motion.
  clear(): void {
    this.loading.abort();
    this.loading = new AbortController();
    this.profiles = [];
    this.notice.clear();
    this.draw();
  }

  close(): void {
    this.removeTheme();
    this.clear();
  }

  private async layersOf(question: ProfileQuestion, signal: AbortSignal): Promise<number[]> {
    if (question.layers.length > 0) return [...question.layers];
    const name = `${databaseName(question.database)}/models/current`;
    const { model } = await this.context.api.models.getModel({ name }, { signal });
    return comparedLayers(model?.nodesPerLayer.length ?? 1);
  }

  // Marks a moment of the motion in all charts.
  mark(seconds: number): void {
    this.seconds = seconds;
    for (const chart of this.drawn) chart.mark(seconds);
  }

  // Charts that are shown already stay, with their zoom.
  private draw(): void {
    const { theme } = this.context;
    const before = this.drawn;
    const labels = this.profiles.flatMap(({ clips }) => clips.map(({ label }) => label));
    this.palette.add(labels);
    const styles = this.palette.styles(theme.name);
    this.drawn = this.profiles.map((profile) => {
      const shown = before.find((chart) => chart.profile === profile);
      shown?.setStyles(styles);
      return shown ?? new ProfileChart(profile, styles, theme, this.seek);
    });
    for (const chart of before) if (!this.drawn.includes(chart)) chart.dispose();
    this.legend.replaceChildren(...legendEntries(labels, styles));
    for (const chart of this.drawn)
      if (chart.node.parentNode !== this.charts) this.charts.append(chart.node);
    this.mark(this.seconds);
  }
}
