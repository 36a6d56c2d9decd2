import type { Disposer } from '../../dom/disposer';
import { Fingers, type FingerMove, type PicturePlace } from '../../dom/fingers';

// What pointers do on the floor. Places are px from its top left.
export interface FloorActions {
  // False: the floor is not shown yet.
  begin: (at: PicturePlace) => boolean;
  drag: (at: PicturePlace) => void;
  end: () => void;
  // A second finger comes: what the first one has placed was no wish.
  interrupt: () => void;
  pinch: (move: FingerMove) => void;
  // The first pointer ends without a result.
  cancel: () => void;
}

// The first finger, or the mouse, draws; with a second finger both move and zoom the floor, until the
// first one is lifted.
export class FloorPointers {
  private readonly fingers = new Fingers();
  private state: 'idle' | 'draw' | 'pinch' = 'idle';

  constructor(
    private readonly svg: SVGElement,
    private readonly actions: FloorActions,
    disposer: Disposer,
  ) {
    disposer.listen<'pointerdown'>(svg, 'pointerdown', (event) => {
      this.down(event);
    });
    disposer.listen<'pointermove'>(svg, 'pointermove', (event) => {
      this.move(event);
    });
    disposer.listen<'pointerup'>(svg, 'pointerup', (event) => {
      this.up(event, actions.end);
    });
    disposer.listen<'pointercancel'>(svg, 'pointercancel', (event) => {
      this.up(event, actions.cancel);
    });
  }

  // A pointer is down.
  get active(): boolean {
    return this.state !== 'idle';
  }

  private down(event: PointerEvent): void {
    const at = this.placeOf(event);
    if (event.isPrimary && event.button === 0) {
      if (!this.actions.begin(at)) return;
      this.state = 'draw';
    } else if (!event.isPrimary && this.active && this.fingers.count === 1) {
      if (this.state === 'draw') this.actions.interrupt();
      this.state = 'pinch';
    } else {
      return;
    }
    this.fingers.down(event.pointerId, at);
    this.svg.setPointerCapture(event.pointerId);
  }

  private move(event: PointerEvent): void {
    const at = this.placeOf(event);
    const move = this.fingers.move(event.pointerId, at);
    if (!move) return;
    if (this.state === 'draw') this.actions.drag(at);
    else if (this.state === 'pinch' && this.fingers.count > 1) this.actions.pinch(move);
  }

  private up(event: PointerEvent, finish: () => void): void {
    this.fingers.up(event.pointerId);
    if (!event.isPrimary || !this.active) return;
    const { state } = this;
    this.state = 'idle';
    if (state === 'draw') finish();
    else this.actions.cancel();
  }

  private placeOf(event: MouseEvent): PicturePlace {
    const box = this.svg.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }
}
