import type { Timestamp } from '@bufbuild/protobuf/wkt';
import { NewestCall } from '../../api/connection';
import { describeError } from '../../api/errors';
import type { Clip } from '../../api/messages';
import { button, element } from '../../dom/element';
import { Notice } from '../../dom/notice';
import type { Motion } from '../../motion/motion';
import type { ViewContext } from '../../shell/view';
import { MotionStage, type StagePart } from '../../stage/motion_stage';

export interface MotionPaneEvents {
  // The first block has arrived.
  started(motion: Motion): void;
  // All frames have arrived.
  completed(motion: Motion): void;
}

// The stage of one clip and its loading.
export class MotionPane {
  readonly node: HTMLElement;
  readonly stage: MotionStage;
  motion: Motion | undefined;
  private readonly attempts: NewestCall;
  private readonly notice = new Notice();
  private readonly loading = element('progress', {
    max: 1,
    value: 0,
    'aria-label': 'Loading motion',
  });

  constructor(
    private readonly context: ViewContext,
    private readonly clip: string,
    private readonly etag: string,
    title: string,
    parts: readonly StagePart[],
    signal: AbortSignal,
    private readonly events: MotionPaneEvents,
  ) {
    this.attempts = new NewestCall(signal);
    this.stage = new MotionStage(
      context.theme,
      `Motion of clip ${title} in three dimensions`,
      parts,
    );
    this.node = element(
      'div',
      { class: 'motion-pane' },
      element('div', { class: 'row' }, element('h2', {}, title), this.loading),
      this.notice.node,
      this.stage.node,
    );
  }

  async load(): Promise<void> {
    const signal = this.attempts.begin();
    this.notice.clear();
    this.loading.hidden = false;
    try {
      const motion = await this.context.motions.load(
        this.clip,
        this.etag,
        signal,
        (started) => {
          this.motion = started;
          this.stage.setMotion(started);
          this.events.started(started);
        },
        (part) => {
          this.loading.value = part.receivedFrames / Math.max(1, part.frameCount);
        },
      );
      if (signal.aborted) return;
      this.loading.hidden = true;
      this.stage.complete();
      this.events.completed(motion);
    } catch (error) {
      if (signal.aborted) return;
      this.loading.hidden = true;
      if (describeError(error)) {
        this.notice.error(error, [button('Try again', () => void this.load())]);
        this.context.connection.whenRestored(error, signal, () => void this.load());
      }
    }
  }

  dispose(): void {
    this.stage.dispose();
    this.node.remove();
  }
}

// Follow from the file of a clip and the code that reads it; edits leave them.
const kDerived = [
  'frameCount',
  'durationSeconds',
  'legLengthM',
  'representationVersion',
  'sourceReport',
] as const;

// True if a clip may have another motion than in the version `before`: it was replaced, or derived
// again from its file. Both give it a new etag and keep the time of its last edit; an edit changes
// this time. New mappings can change the motion and nothing else of the clip.
export function mayHaveNewMotion(before: Clip, now: Clip): boolean {
  if (now.etag === before.etag) return false;
  return (
    isSameTime(now.updateTime, before.updateTime) ||
    !isSameTime(now.createTime, before.createTime) ||
    kDerived.some((field) => now[field] !== before[field])
  );
}

function isSameTime(a: Timestamp | undefined, b: Timestamp | undefined): boolean {
  return a?.seconds === b?.seconds && a?.nanos === b?.nanos;
}
