import '../../style/clip.css';
import { Code } from '@connectrpc/connect';
import { hasCode } from '../../api/errors';
import type { Clip, WatchDatabaseResponse } from '../../api/messages';
import { NewestCall } from '../../api/connection';
import { clipName, isClipId } from '../../api/resource_names';
import { mayActAs } from '../../api/session';
import { Disposer } from '../../dom/disposer';
import { button, element } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { durationOf, type Motion } from '../../motion/motion';
import { driveClock, PlaybackClock } from '../../player/playback_clock';
import { PlayerControls, speedOf } from '../../player/player_controls';
import type { OpenView, ViewContext, ViewParams } from '../../shell/view';
import { kStageParts, type StagePart, partChoices } from '../../stage/motion_stage';
import { ContactRibbon } from '../../timeline/contact_ribbon';
import { SegmentPanel } from '../../timeline/segment_panel';
import { watchDatabase, WatchNotice } from '../../watch/database_watch';
import { OperationProgress } from '../operation_progress';
import { ClipProperties } from './clip_properties';
import { ComparePanel } from './compare_panel';
import { CurvePanel } from './curve_panel';
import { mayHaveNewMotion, MotionPane } from './motion_pane';

// Player of a clip, with its segments and curves.
export const open: OpenView = (host, context, params) => {
  let view: ClipView;
  const show = () => {
    view = new ClipView(host, context, params, () => {
      view.close();
      host.replaceChildren();
      show();
    });
    void view.start();
  };
  show();
  return {
    close: () => {
      view.close();
    },
  };
};

class ClipView {
  private readonly disposer = new Disposer();
  private readonly starting = new NewestCall(this.disposer.signal);
  private readonly notice = new Notice();
  private readonly watchNotice: WatchNotice;
  private readonly motionNotice = new Notice();
  private readonly stages = element('div', { class: 'stages' });
  private readonly below = element('div', { class: 'stack' });
  private readonly controls = element('div', { class: 'panel stack' });
  private readonly progress: OperationProgress;
  private readonly id: string;
  private readonly clock = new PlaybackClock(0, 60);
  // As in the URL that was opened; the view changes the URL later.
  private readonly query: URLSearchParams;
  // The newest version that the page knows; the motion can be that of an older one.
  private clip: Clip | undefined;
  private properties: ClipProperties | undefined;
  private segments: SegmentPanel | undefined;
  private compare: ComparePanel | undefined;

  constructor(
    host: HTMLElement,
    private readonly context: ViewContext,
    private readonly params: ViewParams,
    private readonly reopen: () => void,
  ) {
    this.id = params.path[0] ?? '';
    this.query = new URLSearchParams(params.query);
    this.progress = new OperationProgress(context.api, this.disposer.signal);
    this.watchNotice = new WatchNotice(context.connection);
    const title = element('h1', {}, this.id);
    host.append(
      element(
        'div',
        { class: 'stack' },
        title,
        this.notice.node,
        this.watchNotice.node,
        this.motionNotice.node,
        this.stages,
        this.controls,
        this.below,
      ),
    );
    context.setTitle(this.id);
  }

  async start(): Promise<void> {
    this.notice.clear();
    if (!isClipId(this.id)) {
      this.notice.error(new Error(`Expected the id of a clip, got '${this.id}'.`));
      return;
    }
    const signal = this.starting.begin();
    try {
      const name = clipName(this.params.database, this.id);
      const { clip } = await this.context.api.clips.getClip({ name }, { signal });
      if (clip && !signal.aborted) this.show(clip);
    } catch (error) {
      if (!signal.aborted) this.notice.error(error, [button('Try again', () => void this.start())]);
      this.context.connection.whenRestored(error, signal, () => void this.start());
    }
  }

  close(): void {
    this.disposer.dispose();
  }

  private show(clip: Clip): void {
    const { query } = this;
    this.clip = clip;
    this.clock.speed = speedOf(query.get('speed'));
    this.clock.loop = query.get('loop') !== '0';
    const shown = query.get('show')?.split(',');
    const parts = kStageParts.filter((part) => shown?.includes(part) ?? part !== 'joints');
    const pane = this.openPane(clip, parts);
    const player = new PlayerControls(this.clock, () => {
      const { speed, loop } = this.clock;
      this.context.setQuery({ speed: speed === 1 ? null : speed, loop: loop ? null : '0' });
    });
    const compare = new ComparePanel(
      this.context,
      this.params,
      this.clock,
      this.disposer,
      this.stages,
      pane,
    );
    this.compare = compare;
    this.controls.append(
      player.node,
      element(
        'div',
        { class: 'row' },
        partChoices(parts, (part, on) => {
          pane.stage.setPart(part, on);
          compare.setPart(part, on);
          this.context.setQuery({
            show: kStageParts.filter((each) => pane.stage.has(each)).join(',') || 'none',
          });
        }),
        compare.node,
      ),
    );
    this.disposer.add(() => {
      player.dispose();
    });
    this.disposer.listen(document, 'keydown', (event) => {
      player.press(event);
    });
    this.properties = new ClipProperties({
      api: this.context.api,
      clip,
      editable: mayActAs(this.context.session, 'ingester'),
      signal: this.disposer.signal,
      announce: (text) => {
        this.context.announce(text);
      },
    });
    this.below.append(this.progress.node, this.properties.node);
    this.disposer.add(driveClock(this.clock, pane.stage.scene));
    this.disposer.add(
      this.clock.onChange(() => {
        pane.stage.show(this.clock.time);
        if (!this.clock.playing && pane.motion) this.storeTime();
      }),
    );
    if (query.get('statistics') !== null) this.showStatistics(pane);
    void pane.load();
    void watchDatabase(this.context.api, {
      database: this.params.database,
      signal: this.disposer.signal,
      observer: this.watchNotice,
      changed: (changes) => {
        this.follow(changes);
      },
    });
  }

  // Shows what other clients have changed.
  private follow(changes: readonly WatchDatabaseResponse[]): void {
    const name = clipName(this.params.database, this.id);
    if (changes.length === 0) void this.readAgain(name);
    for (const { change } of changes) {
      if (change.case === 'clip' && change.value.name === name) this.followClip(change.value);
      if (change.case === 'deleted' && change.value === name) this.showDeleted();
    }
    this.segments?.follow(changes);
    this.compare?.follow(changes);
  }

  // Shows the stored properties: changes of other clients can have been missed.
  private async readAgain(name: string): Promise<void> {
    const { signal } = this.disposer;
    try {
      const { clip } = await this.context.api.clips.getClip({ name }, { signal });
      this.notice.clear();
      if (clip) this.followClip(clip);
    } catch (error) {
      if (hasCode(error, Code.NotFound)) this.showDeleted();
      else this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => void this.readAgain(name));
    }
  }

  // A new motion waits until the user loads it: input that is not saved stays.
  private followClip(clip: Clip): void {
    if (this.clip && mayHaveNewMotion(this.clip, clip)) {
      const load = button('Load the new motion', this.reopen);
      this.motionNotice.message(
        'This clip was replaced or derived again. The motion shown here can be the old one.',
        [load],
      );
    }
    this.clip = clip;
    this.properties?.follow(clip);
  }

  private showDeleted(): void {
    this.notice.message('Another client has deleted this clip.');
  }

  private openPane(clip: Clip, parts: readonly StagePart[]): MotionPane {
    const pane: MotionPane = new MotionPane(
      this.context,
      clip.name,
      clip.etag,
      this.id,
      parts,
      this.disposer.signal,
      {
        started: (motion) => {
          if (this.segments) return; // loading was tried again
          this.clock.resize(
            durationOf(motion),
            motion.frameRateHz,
            Number(this.query.get('t') ?? 0),
          );
          if (pane.stage.scene?.orbit.restore(this.query.get('camera'))) pane.stage.keepCamera();
          this.openSegments(clip, pane, motion);
        },
        completed: (motion) => {
          this.openCurves(motion, pane);
          pane.stage.show(this.clock.time);
        },
      },
    );
    pane.stage.scene?.orbit.onEnd(() => {
      this.context.setQuery({ camera: pane.stage.scene?.orbit.state ?? null });
    });
    this.stages.append(pane.node);
    this.disposer.add(() => {
      pane.dispose();
    });
    return pane;
  }

  private openSegments(clip: Clip, pane: MotionPane, motion: Motion): void {
    const panel = new SegmentPanel({
      api: this.context.api,
      connection: this.context.connection,
      clip: clip.name,
      clock: this.clock,
      editable: mayActAs(this.context.session, 'ingester'),
      view: {
        zoom: Number(this.query.get('zoom')) || 1,
        segment: this.query.get('segment') ?? '',
      },
      signal: this.disposer.signal,
      viewed: ({ zoom, segment }) => {
        if (zoom !== undefined) this.context.setQuery({ zoom: zoom === 1 ? null : zoom });
        if (segment !== undefined)
          this.context.setQuery({ segment: segment === '' ? null : segment });
      },
      operation: (operation) => {
        this.progress.watch(operation);
      },
    });
    this.segments = panel;
    this.below.prepend(panel.node);
    if (motion.contacts.length > 0) {
      const ribbon = new ContactRibbon(this.context.theme);
      panel.timeline.addRow(ribbon.node);
      ribbon.draw(motion.contacts);
      this.drawContactsLater(ribbon, pane);
    }
    const show = () => {
      panel.timeline.show(this.clock.time);
    };
    show();
    panel.timeline.reveal();
    this.disposer.add(this.clock.onChange(show));
  }

  // Draws the ribbon again when the rest of the motion has arrived.
  private drawContactsLater(ribbon: ContactRibbon, pane: MotionPane): void {
    this.disposer.add(() => {
      ribbon.dispose();
    });
    const timer = setInterval(() => {
      const { motion } = pane;
      if (!motion) return;
      ribbon.draw(motion.contacts);
      if (motion.receivedFrames >= motion.frameCount) clearInterval(timer);
    }, 300);
    this.disposer.add(() => {
      clearInterval(timer);
    });
  }

  private openCurves(motion: Motion, pane: MotionPane): void {
    const panel = new CurvePanel({
      theme: this.context.theme,
      point: this.query.get('point') ?? '',
      kind: this.query.get('curve') ?? '',
      seek: (seconds) => {
        this.clock.seek(seconds);
      },
      chosen: (point, kind) => {
        this.context.setQuery({ point, curve: kind });
      },
      highlight: (marker) => {
        pane.stage.highlight(marker);
        if (marker >= 0) pane.stage.setTrailPoints([marker]);
      },
    });
    this.below.append(panel.node);
    panel.setMotion(motion);
    panel.setTime(this.clock.time);
    this.disposer.add(() => {
      panel.dispose();
    });
    this.disposer.add(
      this.clock.onChange(() => {
        panel.setTime(this.clock.time, this.clock.playing);
      }),
    );
  }

  private storeTime(): void {
    const { frame, frameRate } = this.clock;
    this.context.setQuery({ t: frame === 0 ? null : Number((frame / frameRate).toFixed(4)) });
  }

  // Work of the main thread and draw calls, for `?statistics=1`.
  private showStatistics(pane: MotionPane): void {
    const output = element('output', { class: 'hint statistics' });
    this.controls.append(output);
    const timer = setInterval(() => {
      const statistics = pane.stage.scene?.statistics;
      if (!statistics) return;
      output.dataset['p95'] = statistics.p95Milliseconds.toFixed(2);
      output.dataset['pictures'] = String(statistics.pictures);
      output.dataset['calls'] = String(statistics.drawCalls);
      output.dataset['rate'] = statistics.rateHz.toFixed(1);
      output.textContent =
        `${statistics.rateHz.toFixed(0)} pictures/s, ${statistics.p95Milliseconds.toFixed(1)} ms (95 %), ` +
        `${statistics.drawCalls} draw calls`;
    }, 500);
    this.disposer.add(() => {
      clearInterval(timer);
    });
  }
}
