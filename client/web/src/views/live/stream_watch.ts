import { Code } from '@connectrpc/connect';
import { hasCode, isConnectionLost } from '../../api/errors';
import { readLabels } from '../../api/lists';
import type { WatchStreamResponse } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { LineChart } from '../../chart/line_chart';
import type { Disposer } from '../../dom/disposer';
import { element, labelled, replaceChildren } from '../../dom/element';
import { count, percent } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { LabelPalette } from '../../drawing/palette';
import type { ViewContext } from '../../shell/view';
import { pause, whileVisible } from '../../watch/waiting';
import { LabelHistory, momentOf, LabelRibbon } from './label_ribbon';
import { LiveStage } from './live_stage';

const kHistorySeconds = 20;
const kLatencies = 200;
const kDrawMilliseconds = 200;
const kRetryMilliseconds = 1500;

// A spectator of one stream: figure, predicted poses, labels and latency.
export class StreamWatch {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly stageHost = element('div');
  private readonly follow = element('input', { type: 'checkbox', checked: true });
  private readonly facts = element('dl', { class: 'details' });
  private readonly history = new LabelHistory(kHistorySeconds);
  private readonly palette = new LabelPalette();
  private readonly ribbon: LabelRibbon;
  private readonly latency: LineChart;
  private readonly latencies: number[] = [];
  private stage: LiveStage | undefined;
  private frameRateHz = 60;
  private skipped = 0n;
  private drawn = 0;

  constructor(
    private readonly context: ViewContext,
    private readonly database: string,
    private readonly stream: string,
    private readonly disposer: Disposer,
    private readonly Stage = LiveStage,
  ) {
    this.ribbon = new LabelRibbon(context.theme, this.palette, kHistorySeconds);
    this.latency = new LineChart({
      theme: context.theme,
      label: 'Latency of the last answers',
      unit: 'ms',
      x: 'answer',
      height: 130,
    });
    const { follow } = this;
    follow.addEventListener('change', () => {
      if (this.stage) this.stage.follow = follow.checked;
    });
    this.node = element(
      'section',
      { class: 'stack', 'aria-label': `Stream ${stream}` },
      element(
        'div',
        { class: 'row' },
        element('h2', {}, `Stream ${stream}`),
        labelled('Follow camera', follow, { class: 'field inline' }),
      ),
      this.notice.node,
      this.stageHost,
      this.ribbon.node,
      this.facts,
      this.latency.node,
    );
    disposer.add(
      context.theme.onChange(() => {
        this.ribbon.draw(this.history.all);
      }),
    );
    disposer.add(() => {
      this.stage?.dispose();
      this.latency.dispose();
    });
  }

  // Watches until the stream ends, while the page is visible; a lost connection is tried again.
  async run(): Promise<void> {
    const { signal } = this.disposer;
    while (!signal.aborted) {
      try {
        await this.openStage();
        const name = `${databaseName(this.database)}/streams/${this.stream}`;
        await whileVisible(signal, async (visible) => {
          this.history.interrupt();
          const { observe } = this.context.api;
          for await (const response of observe.watchStream({ name }, { signal: visible })) {
            this.notice.clear();
            this.show(response);
          }
        });
        this.notice.message('The stream has ended.');
        return;
      } catch (error) {
        if (this.disposer.disposed) return;
        if (hasCode(error, Code.NotFound)) {
          this.notice.message('This stream does not run any more.');
          return;
        }
        this.notice.error(error);
        this.context.connection.failed(error);
        // The store of the server can be away for a while.
        if (!isConnectionLost(error) && !hasCode(error, Code.Unavailable)) return;
        await pause(kRetryMilliseconds, signal);
      }
    }
  }

  private async openStage(): Promise<void> {
    if (this.stage) return;
    const { api } = this.context;
    const { signal } = this.disposer;
    this.palette.add(await readLabels(api, this.database, signal));
    const { figure } = await api.views.getFigure({ name: databaseName(this.database) }, { signal });
    if (!figure || this.disposer.disposed) return;
    this.stage = new this.Stage(this.context.theme, figure);
    this.stage.follow = this.follow.checked;
    this.stageHost.append(this.stage.node);
  }

  private show(response: WatchStreamResponse): void {
    if (response.stream) this.frameRateHz = response.stream.frameRateHz;
    const { answer } = response;
    if (!answer) return;
    this.stage?.show(response);
    this.history.add(momentOf(answer, this.frameRateHz));
    this.skipped += response.skippedCount;
    this.latencies.push(1000 * response.latencySeconds);
    if (this.latencies.length > kLatencies) this.latencies.shift();
    const now = performance.now();
    if (now - this.drawn < kDrawMilliseconds) return;
    this.drawn = now;
    this.ribbon.draw(this.history.all);
    this.drawFacts(response);
    this.latency.setData(
      this.latencies.map((_, index) => index - this.latencies.length + 1),
      [{ name: 'latency', color: '--accent', values: this.latencies }],
    );
  }

  private drawFacts(response: WatchStreamResponse): void {
    const { answer } = response;
    if (!answer) return;
    const labels = answer.labels
      .slice(0, 3)
      .map((each) => `${each.label} ${percent(each.probability)}`);
    const predictions = answer.horizons.map((horizon) => {
      const expected = horizon.expectedErrorM;
      const text =
        expected === undefined
          ? 'error not known'
          : `expected error ${(100 * expected).toFixed(1)} cm`;
      return `${horizon.seconds.toFixed(2)} s: ${text}`;
    });
    const entries: [string, string][] = [
      ['Frame', count(answer.frame)],
      ['Labels', labels.join(', ')],
      [
        'Unknown',
        answer.unknownProbability === undefined ? '' : percent(answer.unknownProbability),
      ],
      ['Familiarity', answer.familiarity.toFixed(2)],
      ['Prediction', predictions.join('; ')],
      ['Latency', `${(1000 * response.latencySeconds).toFixed(1)} ms`],
      ['Answers left out', count(this.skipped)],
    ];
    replaceChildren(
      this.facts,
      ...entries.flatMap(([name, value]) =>
        value === '' ? [] : [element('dt', {}, name), element('dd', {}, value)],
      ),
    );
  }
}
