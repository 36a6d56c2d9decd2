import '../../style/clips.css';
import type { Clip, Facet } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { mayActAs } from '../../api/session';
import { Disposer } from '../../dom/disposer';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { count } from '../../dom/format';
import { Notice } from '../../dom/notice';
import type { OpenView, ViewContext, ViewParams } from '../../shell/view';
import { watchDatabase, WatchNotice } from '../../watch/database_watch';
import { OperationProgress } from '../operation_progress';
import { kFacetFields, kPageSize, previousPages, queryOf, stateOf } from './clip_list_state';
import { ClipTable } from './clip_table';
import { FacetPanel } from './facet_panel';
import { FilterBox } from './filter_box';
import { Thumbnails } from './thumbnail';
import { UploadPanel } from './upload_panel';

const kSettleMilliseconds = 300;

// The clips of a database: list, search and upload.
export const open: OpenView = (host, context, params) => {
  const view = new ClipsView(host, context, params);
  view.start();
  return {
    close: () => {
      view.close();
    },
  };
};

interface Page {
  clips: Clip[];
  total: number;
  next: string;
  facets: Facet[];
}

class ClipsView {
  private readonly disposer = new Disposer();
  private readonly state;
  private readonly filterBox: FilterBox;
  private readonly facets: FacetPanel;
  private readonly table: ClipTable;
  private readonly progress: OperationProgress;
  private readonly total = element('p', { class: 'hint', role: 'status' });
  private readonly list = element('div', { class: 'clip-list' });
  private readonly pager = element('nav', { class: 'row', 'aria-label': 'Pages' });
  // Of a clip that could not be deleted. Reads of the list leave it.
  private readonly notice = new Notice();
  private readonly watchNotice: WatchNotice;
  private reading: AbortController | undefined;
  private timer: ReturnType<typeof setTimeout> | undefined;

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
  ) {
    this.state = stateOf(params.query);
    const mayChange = mayActAs(context.session, 'ingester');
    this.watchNotice = new WatchNotice(context.connection);
    this.filterBox = new FilterBox(this.state.filter, this.state.search, {
      apply: (filter, search) => {
        this.change({ filter, search });
      },
    });
    this.facets = new FacetPanel((filter) => {
      this.filterBox.set(filter, this.state.search);
      this.change({ filter });
    });
    this.table = new ClipTable({
      database: params.database,
      thumbnails: new Thumbnails(context.api, context.theme, this.disposer.signal),
      remove: mayChange ? (clip) => this.remove(clip) : null,
      order: (orderBy) => {
        this.change({ orderBy });
      },
    });
    this.progress = new OperationProgress(
      context.api,
      this.disposer.signal,
      () => void this.read(),
    );
    this.list.append(
      this.facets.node,
      element('div', { class: 'stack' }, this.total, this.table.node, this.pager),
    );
    host.append(
      element(
        'div',
        { class: 'stack' },
        element('h1', {}, `Clips of ${params.database}`),
        mayChange && this.openUpload().node,
        this.progress.node,
        this.filterBox.node,
        this.notice.node,
        this.watchNotice.node,
        this.list,
      ),
    );
  }

  start(): void {
    void this.read();
    void this.watchOperation();
    void watchDatabase(this.context.api, {
      database: this.params.database,
      signal: this.disposer.signal,
      observer: this.watchNotice,
      changed: () => {
        this.readSoon();
      },
    });
    this.disposer.add(() => {
      clearTimeout(this.timer);
    });
    this.disposer.add(
      this.context.connection.onChange((state) => {
        if (state === 'connected') void this.read();
      }),
    );
  }

  close(): void {
    this.disposer.dispose();
    this.reading?.abort();
  }

  private openUpload(): UploadPanel {
    const panel = new UploadPanel(
      this.context,
      this.params.database,
      this.disposer,
      (operation) => {
        if (operation) this.progress.watch(operation);
        void this.read();
      },
    );
    return panel;
  }

  private change(change: Partial<{ filter: string; search: string; orderBy: string }>): void {
    Object.assign(this.state, change, { pages: [] });
    this.context.setQuery(queryOf(this.state));
    void this.read();
  }

  private turnTo(pages: string[]): void {
    this.state.pages = pages;
    this.context.setQuery(queryOf(this.state));
    void this.read();
  }

  // Changes of other clients come in bursts, for example while files are ingested.
  private readSoon(): void {
    this.timer ??= setTimeout(() => {
      this.timer = undefined;
      void this.read();
      void this.watchOperation();
    }, kSettleMilliseconds);
  }

  // Reads the page; an older answer is dropped.
  private async read(): Promise<void> {
    this.reading?.abort();
    const controller = new AbortController();
    this.reading = controller;
    const { filter } = this.state;
    try {
      const page = await this.readPage(controller.signal);
      if (controller.signal.aborted || this.disposer.disposed) return;
      this.filterBox.clearError();
      // A click needs the same element when the pointer is released.
      if (this.list.matches(':active')) this.readSoon();
      else this.draw(page);
    } catch (error) {
      if (!controller.signal.aborted) this.filterBox.showError(error, filter);
    }
  }

  private async readPage(signal: AbortSignal): Promise<Page> {
    const { filter, search, orderBy, pages } = this.state;
    const request = {
      parent: databaseName(this.params.database),
      pageSize: kPageSize,
      pageToken: pages.at(-1) ?? '',
      filter,
      facets: [...kFacetFields],
    };
    if (search !== '') {
      const found = await this.context.api.clips.searchClips(
        { ...request, query: search },
        { signal },
      );
      const clips = found.matches.flatMap((match) => (match.clip ? [match.clip] : []));
      const { totalCount: total, nextPageToken: next, facets } = found;
      return { clips, total, next, facets };
    }
    const list = await this.context.api.clips.listClips({ ...request, orderBy }, { signal });
    return {
      clips: list.clips,
      total: list.totalCount,
      next: list.nextPageToken,
      facets: list.facets,
    };
  }

  private draw(page: Page): void {
    const searching = this.state.search !== '';
    this.table.draw(page.clips, searching ? null : this.state.orderBy);
    this.facets.draw(page.facets, this.state.filter);
    const first = this.state.pages.length * kPageSize;
    this.total.textContent =
      page.clips.length === 0
        ? `${count(page.total)} clips`
        : `Clips ${count(first + 1)} to ${count(first + page.clips.length)} of ${count(page.total)}`;
    const previous = button(
      'Previous page',
      () => {
        this.turnTo(previousPages(this.state.pages));
      },
      { 'data-key': 'previous' },
    );
    previous.disabled = this.state.pages.length === 0;
    const next = button(
      'Next page',
      () => {
        this.turnTo([...this.state.pages, page.next]);
      },
      { 'data-key': 'next' },
    );
    next.disabled = page.next === '';
    keepFocus(this.pager, () => {
      replaceChildren(this.pager, previous, next);
    });
  }

  private async remove(clip: Clip): Promise<boolean> {
    this.notice.clear();
    try {
      const { operation } = await this.context.api.clips.deleteClip(
        { name: clip.name },
        { signal: this.disposer.signal },
      );
      if (operation) this.progress.watch(operation);
      this.context.announce('Clip deleted');
      await this.read();
      return true;
    } catch (error) {
      this.notice.error(error);
      return false;
    }
  }

  // Shows the progress of a rebuild that runs already.
  private async watchOperation(): Promise<void> {
    try {
      const { operations } = await this.context.api.operations.listOperations(
        { parent: databaseName(this.params.database), pageSize: 1 },
        { signal: this.disposer.signal },
      );
      const [newest] = operations;
      if (newest?.result.case === undefined && newest !== undefined) this.progress.watch(newest);
    } catch {
      // The list of clips reports a lost connection.
    }
  }
}
