import type { GetServerStatusResponse } from '../../api/messages';
import { lastPart } from '../../api/resource_names';
import { LineChart, type ChartLine } from '../../chart/line_chart';
import type { Disposer } from '../../dom/disposer';
import { element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { bytes, count, percent } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { poll } from '../../watch/waiting';
import { tableOf } from '../../dom/table';
import { hrefOf } from '../../shell/place';
import type { ViewContext } from '../../shell/view';
import { statusFacts, StatusHistory } from './status_values';

const kPollMilliseconds = 2000;

// Status of the server: facts, charts of the last minutes, and databases.
export class StatusPanel {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly facts = element('dl', { class: 'details' });
  private readonly databases = element('div');
  private readonly history = new StatusHistory();
  private readonly charts: { chart: LineChart; lines: () => ChartLine[] }[];

  constructor(
    private readonly context: ViewContext,
    private readonly disposer: Disposer,
  ) {
    const chart = (label: string, unit: string, lines: () => ChartLine[]) => ({
      chart: new LineChart({ theme: context.theme, label, unit, times: true, height: 150 }),
      lines,
    });
    const { history } = this;
    this.charts = [
      chart('Calls per second', 'calls/s', () => [
        { name: 'calls', color: '--left', values: history.callsPerSecond },
        { name: 'server errors', color: '--error', values: history.failuresPerSecond },
      ]),
      chart('Memory of the server', 'MiB', () => [
        { name: 'memory', color: '--trail', values: history.memoryMib },
      ]),
      chart('Processor cores in use', 'cores', () => [
        { name: 'cores', color: '--right', values: history.cpu },
      ]),
      chart('Open calls', 'calls', () => [
        { name: 'open', color: '--ghost', values: history.openCalls },
      ]),
    ];
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Status' },
      element('h2', {}, 'Status'),
      this.notice.node,
      this.facts,
      element('div', { class: 'charts' }, ...this.charts.map(({ chart: each }) => each.node)),
      this.databases,
    );
    disposer.add(() => {
      for (const { chart: each } of this.charts) each.dispose();
    });
    poll(disposer, kPollMilliseconds, () => this.read());
  }

  private async read(): Promise<void> {
    try {
      const status = await this.context.api.server.getServerStatus(
        {},
        { signal: this.disposer.signal },
      );
      this.notice.clear();
      this.history.add(status, Date.now() / 1000);
      this.draw(status);
    } catch (error) {
      this.notice.error(error);
    }
  }

  private draw(status: GetServerStatusResponse): void {
    replaceChildren(
      this.facts,
      ...statusFacts(status, this.history.cpu.at(-1) ?? null).flatMap(([name, text]) => [
        element('dt', {}, name),
        element('dd', {}, text),
      ]),
    );
    for (const { chart, lines } of this.charts) chart.setData(this.history.times, lines());
    // A click needs the same button when the pointer is released.
    if (this.databases.matches(':active')) return;
    keepFocus(this.databases, () => {
      this.drawDatabases(status);
    });
  }

  private drawDatabases(status: GetServerStatusResponse): void {
    replaceChildren(
      this.databases,
      tableOf(
        'Databases',
        [
          { title: 'Database' },
          { title: 'Clips', number: true },
          { title: 'Frames', number: true },
          { title: 'Model', number: true },
          { title: 'Size', number: true },
          { title: 'Operation' },
        ],
        status.databases.map((database) => {
          const id = lastPart(database.name);
          return [
            element('a', { href: hrefOf({ view: 'clips', database: id }), 'data-key': id }, id),
            count(database.clipCount),
            count(database.storedFrameCount),
            count(database.modelVersion),
            bytes(database.byteCount),
            database.operation === '' ? '' : `${database.stage}, ${percent(database.progress)}`,
          ];
        }),
      ),
    );
  }
}
