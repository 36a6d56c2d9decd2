import '../../style/clip.css';
import '../database/database.css';
import './query.css';
import { readClipIds, readLabels } from '../../api/lists';
import type { RecognitionWindow } from '../../api/messages';
import { NewestCall } from '../../api/connection';
import { databaseName } from '../../api/resource_names';
import { Disposer } from '../../dom/disposer';
import { element } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { LabelPalette } from '../../drawing/palette';
import { durationOf, snapToFrame } from '../../motion/motion';
import { driveClock, PlaybackClock } from '../../player/playback_clock';
import { PlayerControls } from '../../player/player_controls';
import type { View, ViewContext, ViewParams } from '../../shell/view';
import { MotionStage } from '../../stage/motion_stage';
import { Ghosts } from './ghosts';
import { MomentPanel } from './moment_panel';
import { observationOf, observeClip, observeFiles, type ObservedMotion } from './observed_motion';
import { PathMap } from './path_map';
import { askMoment, comparePoses } from './prediction';
import { ProfilePanel } from './profile_panel';
import { filterOf, queryOfSettings, querySettingsOf, type QuerySettings } from './query_settings';
import { RecognitionRibbon } from './ribbon';
import { SourceForm, type QuerySource } from './source_form';

// The view of queries about a motion: recognition, generation probability, estimation, prediction.
export function open(host: HTMLElement, context: ViewContext, params: ViewParams): View {
  const page = new QueryPage(host, context, params);
  page.start();
  return page;
}

class QueryPage implements View {
  private readonly disposer = new Disposer();
  private readonly notice = new Notice();
  private readonly form: SourceForm;
  private readonly stage: MotionStage;
  private readonly clock = new PlaybackClock(0, 60);
  private readonly player: PlayerControls;
  private readonly ribbon: RecognitionRibbon;
  private readonly moment: MomentPanel;
  private readonly ghosts: Ghosts;
  private readonly pathMap: PathMap;
  private readonly profiles: ProfilePanel;
  private readonly palette = new LabelPalette();
  private readonly answer = element('div', { class: 'stack', hidden: true });
  private settings: QuerySettings;
  private observed: ObservedMotion | undefined;
  private windows: readonly RecognitionWindow[] = [];
  private asking = new AbortController();
  private readonly predicting = new NewestCall(this.disposer.signal);

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
  ) {
    const { api, theme } = context;
    const seek = (seconds: number) => {
      this.clock.pause();
      this.clock.seek(seconds);
    };
    this.settings = querySettingsOf(params.query);
    this.form = new SourceForm(this.settings, (source) => {
      this.change({ at: undefined, ...source.settings });
      void this.ask(source);
    });
    this.stage = new MotionStage(theme, 'The observed motion with predicted poses', ['markers']);
    this.player = new PlayerControls(this.clock);
    this.ribbon = new RecognitionRibbon(seek);
    this.ghosts = new Ghosts(this.stage.scene);
    this.pathMap = new PathMap(api, theme, params.database, this.palette);
    this.moment = new MomentPanel(
      () => void this.askMoment(this.clock.time),
      () => {
        this.clearMoment();
      },
    );
    this.profiles = new ProfilePanel(context, this.palette, seek, (layers) => {
      this.change({ layers });
      void this.loadProfiles();
    });
    this.answer.append(
      this.stage.node,
      this.player.node,
      this.ribbon.node,
      this.moment.node,
      this.pathMap.node,
      this.profiles.node,
    );
    const title = element('h1', {}, `Query ${params.database}`);
    host.append(
      element('div', { class: 'stack' }, title, this.form.node, this.notice.node, this.answer),
    );
    this.connect();
  }

  start(): void {
    void this.offerNames();
    if (this.settings.clip !== '') void this.ask({ settings: {}, files: [] });
  }

  close(): void {
    this.disposer.dispose();
    this.asking.abort();
    this.clock.pause();
    this.player.dispose();
    this.ghosts.clear();
    this.stage.dispose();
    this.pathMap.close();
    this.profiles.close();
  }

  private connect(): void {
    this.disposer.add(driveClock(this.clock, this.stage.scene));
    this.disposer.add(
      this.clock.onChange(() => {
        this.stage.show(this.clock.time);
        this.ribbon.mark(this.clock.time);
        this.profiles.mark(this.clock.time);
      }),
    );
    this.disposer.add(
      this.context.theme.onChange(() => {
        this.drawRibbon();
        this.pathMap.drawLegend();
      }),
    );
    this.disposer.listen<'keydown'>(document, 'keydown', (event) => {
      if (this.observed) this.player.press(event);
    });
  }

  private change(changes: Partial<QuerySettings>): void {
    this.settings = { ...this.settings, ...changes };
    this.context.setQuery(queryOfSettings(this.settings));
  }

  // Reads the motion, shows it, and recognizes it; then answers for the moment and the layers of the
  // URL.
  private async ask(source: QuerySource): Promise<void> {
    const { files } = source;
    this.asking.abort();
    this.asking = new AbortController();
    const { signal } = this.asking;
    const { api } = this.context;
    const { clip, from, to, at } = this.settings;
    const { database } = this.params;
    this.clearMoment(false);
    this.profiles.clear();
    this.observed = undefined;
    this.windows = [];
    this.answer.hidden = true;
    this.clock.pause();
    if (clip === '' && files.length === 0) {
      this.notice.message('Choose a clip of the database or a motion file.');
      return;
    }
    try {
      this.notice.message('Reading the motion ...');
      this.observed =
        files.length > 0
          ? await observeFiles(api, database, files, signal)
          : await observeClip(api, database, clip, from, to, signal);
      this.showMotion(this.observed);
      this.notice.message('Recognizing ...');
      const labels = readLabels(api, database, signal);
      const recognized = api.queries.recognize(
        {
          database: databaseName(database),
          observation: observationOf(this.observed),
          windowSeconds: this.settings.window,
          filter: filterOf(this.settings),
          track: this.settings.track,
          topCount: 1,
        },
        { signal },
      );
      const [response, known] = await Promise.all([recognized, labels]);
      this.palette.add(known);
      this.windows = response.windows;
      this.notice.clear();
      this.drawRibbon();
      this.context.announce(`${response.windows.length} windows recognized`);
      if (this.settings.layers.length > 0) void this.loadProfiles();
      // The time in the address is rounded.
      if (at !== undefined) await this.askMoment(snapToFrame(at, this.observed.motion.frameRateHz));
    } catch (error) {
      if (!signal.aborted) this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => void this.ask(source));
    }
  }

  private showMotion({ motion }: ObservedMotion): void {
    this.answer.hidden = false;
    this.windows = [];
    this.clock.pause();
    this.clock.resize(durationOf(motion), motion.frameRateHz, this.settings.at ?? 0);
    this.stage.setMotion(motion);
    this.stage.complete();
    this.drawRibbon();
  }

  private drawRibbon(): void {
    if (!this.observed) return;
    this.palette.add(this.windows.flatMap(({ labels }) => labels.map(({ label }) => label)));
    const styles = this.palette.styles(this.context.theme.name);
    this.ribbon.show(this.windows, durationOf(this.observed.motion), styles);
    this.ribbon.mark(this.clock.time);
  }

  private async askMoment(at: number): Promise<void> {
    const { observed } = this;
    if (!observed) return;
    const signal = this.predicting.begin();
    this.clock.pause();
    this.clock.seek(at);
    this.change({ at });
    try {
      this.moment.notice.message('Predicting ...');
      const question = {
        database: this.params.database,
        observed,
        filter: filterOf(this.settings),
      };
      const { history } = this.settings;
      const answer = await askMoment(this.context.api, question, at, history, signal);
      if (signal.aborted) return;
      const poses = comparePoses(observed, answer.prediction);
      this.moment.notice.clear();
      this.moment.show(answer, poses, observed.motion.markers);
      this.ghosts.show(observed.motion.markers, poses);
      await this.pathMap.show(answer, signal);
    } catch (error) {
      if (!signal.aborted) {
        this.hideMoment();
        this.moment.notice.error(error);
      }
      this.context.connection.whenRestored(error, signal, () => void this.askMoment(at));
    }
  }

  private clearMoment(forget = true): void {
    this.predicting.stop();
    if (forget) this.change({ at: undefined });
    this.hideMoment();
  }

  private hideMoment(): void {
    this.moment.clear();
    this.ghosts.clear();
    this.pathMap.hide();
  }

  private async loadProfiles(): Promise<void> {
    const { observed } = this;
    if (!observed) return;
    const { window, layers } = this.settings;
    const { database } = this.params;
    await this.profiles.load({
      database,
      observed,
      filter: filterOf(this.settings),
      window,
      layers,
      chosen: (shown) => {
        this.change({ layers: shown });
      },
    });
  }

  private async offerNames(): Promise<void> {
    try {
      const { api } = this.context;
      const { database } = this.params;
      const { signal } = this.disposer;
      const counted = { parent: databaseName(database), pageSize: 1, facets: ['track'] };
      const [clips, { facets }] = await Promise.all([
        readClipIds(api, database, { signal }),
        api.clips.listClips(counted, { signal }),
      ]);
      const tracks = facets.flatMap((facet) => facet.values.map(({ value }) => value));
      this.form.offer(clips, tracks);
    } catch (error) {
      if (!this.disposer.disposed) this.notice.error(error);
      this.context.connection.whenRestored(
        error,
        this.disposer.signal,
        () => void this.offerNames(),
      );
    }
  }
}
