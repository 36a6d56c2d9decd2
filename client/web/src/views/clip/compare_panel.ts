import { Code } from '@connectrpc/connect';
import { hasCode } from '../../api/errors';
import { readClipIds } from '../../api/lists';
import type { Clip, WatchDatabaseResponse } from '../../api/messages';
import { NewestCall } from '../../api/connection';
import { clipName } from '../../api/resource_names';
import type { Disposer } from '../../dom/disposer';
import { button, element, labelled, offerNames } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { alignmentOffset } from '../../motion/alignment';
import type { PlaybackClock } from '../../player/playback_clock';
import type { ViewContext, ViewParams } from '../../shell/view';
import { kStageParts, type StagePart } from '../../stage/motion_stage';
import { mayHaveNewMotion, MotionPane } from './motion_pane';

// A second clip beside the first, shown at the same time plus an offset.
export class ComparePanel {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly motionNotice = new Notice();
  private unlinkCameras: () => void = () => undefined;
  private readonly namesNotice = new Notice();
  private readonly clip: HTMLInputElement;
  private readonly names = element('datalist', { id: 'compare-clips' });
  private readonly offset: HTMLInputElement;
  private readonly align: HTMLButtonElement;
  private readonly opening: NewestCall;
  private pane: MotionPane | undefined;
  // The newest version that the page knows; the motion can be that of an older one.
  private second: Clip | undefined;

  constructor(
    private readonly context: ViewContext,
    private readonly params: ViewParams,
    private readonly clock: PlaybackClock,
    private readonly disposer: Disposer,
    private readonly stages: HTMLElement,
    private readonly first: MotionPane,
  ) {
    this.opening = new NewestCall(disposer.signal);
    this.clip = element('input', {
      list: this.names.id,
      value: params.query.get('with') ?? '',
      placeholder: 'none',
    });
    this.offset = element('input', {
      type: 'number',
      step: 'any',
      value: params.query.get('offset') ?? '0',
    });
    this.align = button(
      'Align',
      () => {
        this.alignClips();
      },
      { title: 'Finds the offset at which the motions are most alike' },
    );
    this.align.disabled = true;
    this.node = element(
      'div',
      { class: 'row', role: 'group', 'aria-label': 'Side by side' },
      labelled('Side by side with clip', this.clip),
      this.names,
      labelled('Offset, s', this.offset),
      this.align,
      this.notice.node,
      this.motionNotice.node,
      this.namesNotice.node,
    );
    this.clip.addEventListener('change', () => void this.openClip());
    this.clip.addEventListener('focus', () => void this.listNames(), { once: true });
    this.offset.addEventListener('change', () => {
      this.show();
    });
    disposer.add(
      clock.onChange(() => {
        this.pane?.stage.show(clock.time + this.offsetSeconds);
      }),
    );
    disposer.add(() => {
      this.closePane();
    });
    if (this.clip.value !== '') void this.openClip();
  }

  setPart(part: StagePart, on: boolean): void {
    this.pane?.stage.setPart(part, on);
  }

  // Shows what other clients have changed. No changes: some can have been missed.
  follow(changes: readonly WatchDatabaseResponse[]): void {
    if (changes.length === 0) void this.readAgain();
    for (const { change } of changes) {
      const name = this.second?.name;
      if (change.case === 'clip' && change.value.name === name) this.followClip(change.value);
      if (change.case === 'deleted' && change.value === name) this.showDeleted();
    }
  }

  private async readAgain(): Promise<void> {
    const { second, pane } = this;
    if (!second) return;
    const { signal } = this.disposer;
    try {
      const { clip } = await this.context.api.clips.getClip({ name: second.name }, { signal });
      if (clip && this.pane === pane) this.followClip(clip);
    } catch (error) {
      if (this.pane !== pane) return;
      if (hasCode(error, Code.NotFound)) this.showDeleted();
      this.context.connection.whenRestored(error, signal, () => void this.readAgain());
    }
  }

  // A new motion waits until the user loads it, as that of the first clip.
  private followClip(clip: Clip): void {
    if (this.second && mayHaveNewMotion(this.second, clip)) {
      this.motionNotice.message(
        'The second clip was replaced or derived again. Its motion shown here can be the old one.',
        [button('Load the new motion of the second clip', () => void this.openClip())],
      );
    }
    this.second = clip;
  }

  private showDeleted(): void {
    this.motionNotice.message('Another client has deleted the second clip.');
  }

  private get offsetSeconds(): number {
    return Number(this.offset.value) || 0;
  }

  private show(): void {
    this.context.setQuery({ offset: this.offsetSeconds === 0 ? null : this.offset.value });
    this.pane?.stage.show(this.clock.time + this.offsetSeconds);
  }

  private async listNames(): Promise<void> {
    try {
      const { signal } = this.disposer;
      offerNames(this.names, await readClipIds(this.context.api, this.params.database, { signal }));
      this.namesNotice.clear();
    } catch (error) {
      this.namesNotice.error(error);
      this.context.connection.whenRestored(
        error,
        this.disposer.signal,
        () => void this.listNames(),
      );
    }
  }

  private async openClip(): Promise<void> {
    const signal = this.opening.begin();
    this.closePane();
    this.align.disabled = true;
    this.notice.clear();
    const id = this.clip.value.trim();
    this.context.setQuery({ with: id });
    this.stages.classList.toggle('pair', id !== '');
    if (id === '') return;
    try {
      const name = clipName(this.params.database, id);
      const { clip } = await this.context.api.clips.getClip({ name }, { signal });
      if (!clip || signal.aborted) return;
      const parts = kStageParts.filter((part) => this.first.stage.has(part));
      const pane: MotionPane = new MotionPane(
        this.context,
        clip.name,
        clip.etag,
        id,
        parts,
        signal,
        {
          started: () => {
            this.show();
          },
          completed: () => {
            this.align.disabled = false;
            pane.stage.show(this.clock.time + this.offsetSeconds);
          },
        },
      );
      this.pane = pane;
      this.second = clip;
      this.stages.append(pane.node);
      this.linkCameras(pane);
      void pane.load();
    } catch (error) {
      if (signal.aborted) return;
      this.stages.classList.remove('pair');
      this.notice.error(error);
      this.context.connection.whenRestored(error, signal, () => void this.openClip());
    }
  }

  private closePane(): void {
    this.unlinkCameras();
    this.unlinkCameras = () => undefined;
    this.pane?.dispose();
    this.pane = undefined;
    this.second = undefined;
    this.motionNotice.clear();
  }

  // The second camera looks from the same side as the first.
  private linkCameras(pane: MotionPane): void {
    const first = this.first.stage.scene?.orbit;
    const second = pane.stage.scene?.orbit;
    if (!first || !second) return;
    this.unlinkCameras = first.onMove(() => {
      second.copyView(first);
    });
  }

  private alignClips(): void {
    const motion = this.first.motion;
    const other = this.pane?.motion;
    if (!motion || !other) return;
    this.notice.clear();
    if (motion.receivedFrames < motion.frameCount) {
      this.notice.message('The first clip is still loading.');
      return;
    }
    this.offset.value = alignmentOffset(motion, other).toFixed(3);
    this.show();
    this.context.announce(`Offset ${this.offset.value} seconds`);
  }
}
