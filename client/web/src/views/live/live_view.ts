import '../../style/live.css';
import type { ObservedStream } from '../../api/messages';
import { databaseName, lastPart } from '../../api/resource_names';
import { Disposer } from '../../dom/disposer';
import { element, replaceChildren } from '../../dom/element';
import { count, time } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { poll } from '../../watch/waiting';
import { hrefOf } from '../../shell/place';
import type { OpenView, ViewContext, ViewParams } from '../../shell/view';
import { StreamWatch } from './stream_watch';

const kListMilliseconds = 2000;

// Running streams, and the answers of one of them.
export const open: OpenView = (host, context, params) => {
  const view = new LiveView(host, context, params);
  return {
    close: () => {
      view.close();
    },
  };
};

class LiveView {
  private readonly disposer = new Disposer();
  private readonly notice = new Notice();
  private readonly streams = element('div', { class: 'table-scroll' });
  private readonly chosen: string;

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
  ) {
    this.chosen = params.path[0] ?? '';
    const watch =
      this.chosen === ''
        ? undefined
        : new StreamWatch(context, params.database, this.chosen, this.disposer);
    host.append(
      element(
        'div',
        { class: 'stack' },
        element('h1', {}, `Live streams of ${params.database}`),
        watch?.node,
        this.notice.node,
        this.streams,
      ),
    );
    poll(this.disposer, kListMilliseconds, () => this.list());
    void watch?.run();
  }

  close(): void {
    this.disposer.dispose();
  }

  private async list(): Promise<void> {
    try {
      const { streams } = await this.context.api.observe.listStreams(
        { parent: databaseName(this.params.database) },
        { signal: this.disposer.signal },
      );
      this.notice.clear();
      this.draw(streams);
    } catch (error) {
      this.notice.error(error);
    }
  }

  private draw(streams: readonly ObservedStream[]): void {
    // A link that has the focus stays: the table is drawn anew only if the streams are others.
    const ids = streams.map((stream) => lastPart(stream.name)).join(' ');
    if (this.streams.dataset['ids'] === ids) {
      streams.forEach((stream, index) => {
        const cell = this.streams.querySelectorAll('td.frame')[index];
        if (cell) cell.textContent = count(stream.frame);
      });
      return;
    }
    this.streams.dataset['ids'] = ids;
    const head = ['Stream', 'Caller', 'Since', 'Frame', 'Frame rate'].map((title) =>
      element('th', { scope: 'col' }, title),
    );
    replaceChildren(
      this.streams,
      streams.length === 0
        ? element(
            'p',
            { class: 'hint' },
            'No stream runs. A client starts one with the call Observe.',
          )
        : element(
            'table',
            {},
            element('thead', {}, element('tr', {}, ...head)),
            element('tbody', {}, ...streams.map((stream) => this.row(stream))),
          ),
    );
  }

  private row(stream: ObservedStream): HTMLElement {
    const id = lastPart(stream.name);
    const href = hrefOf({ view: 'live', database: this.params.database, path: [id] });
    const current = id === this.chosen ? 'true' : null;
    return element(
      'tr',
      {},
      element('td', {}, element('a', { href, 'aria-current': current }, id)),
      element('td', {}, stream.caller),
      element('td', {}, time(stream.startTime)),
      element('td', { class: 'frame' }, count(stream.frame)),
      element('td', {}, `${stream.frameRateHz} Hz`),
    );
  }
}
