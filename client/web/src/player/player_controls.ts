import { button, element, labelled, selectOf } from '../dom/element';
import { clock as clockText } from '../dom/format';
import { readChoice, storeChoice } from '../dom/browser_storage';
import type { PlaybackClock } from './playback_clock';

// While the motion plays, text and slider follow it at this interval.
const kDrawMilliseconds = 50;
const kSpeeds = ['0.1', '0.25', '0.5', '1', '2', '4'] as const;

// The speed of a text; 1 if it is not an offered speed.
export function speedOf(text: string | null): number {
  return Number(kSpeeds.find((value) => value === text) ?? '1');
}

// Buttons, slider and keys of a clock: space plays, comma and full stop step by a frame, Home and
// End go to the ends.
export class PlayerControls {
  readonly node: HTMLElement;
  private readonly playButton: HTMLButtonElement;
  private readonly slider: HTMLInputElement;
  // Single letters as commands disturb speech input (WCAG 2.1.4), so they can be switched off.
  private readonly keys: HTMLInputElement;
  private readonly position = element('span', { class: 'position' });
  private readonly remove: () => void;
  private shownFrame = -1;
  private shownPlaying: boolean | null = null;
  private drawnAt = -Infinity;

  // `changed`: the user has chosen another speed, or loop.
  constructor(
    private readonly clock: PlaybackClock,
    changed: () => void = () => undefined,
  ) {
    this.playButton = button(
      'Play',
      () => {
        clock.toggle();
      },
      { class: 'play' },
    );
    this.slider = element('input', {
      type: 'range',
      min: 0,
      step: 1,
      value: 0,
      'aria-label': 'Frame',
    });
    this.slider.addEventListener('input', () => {
      clock.seek(Number(this.slider.value) / clock.frameRate);
    });
    const speed = selectOf(
      kSpeeds.map((value) => [value, `${value} x`] as const),
      kSpeeds.find((value) => Number(value) === clock.speed) ?? '1',
    );
    speed.addEventListener('change', () => {
      clock.speed = Number(speed.value);
      changed();
    });
    const loop = element('input', { type: 'checkbox', checked: clock.loop });
    loop.addEventListener('change', () => {
      clock.loop = loop.checked;
      changed();
    });
    this.keys = element('input', { type: 'checkbox', checked: readChoice('keys') !== 'off' });
    this.keys.addEventListener('change', () => {
      storeChoice('keys', this.keys.checked ? 'on' : 'off');
    });
    this.node = element(
      'div',
      { class: 'player row', role: 'group', 'aria-label': 'Player' },
      this.playButton,
      this.stepButton('Previous frame', '◀', -1),
      this.stepButton('Next frame', '▶', 1),
      this.slider,
      this.position,
      labelled('Speed', speed, { class: 'field inline' }),
      labelled('Loop', loop, { class: 'field inline' }),
      labelled('Keys , and .', this.keys, { class: 'field inline' }),
    );
    this.remove = clock.onChange(() => {
      this.draw();
    });
    this.draw();
  }

  // Handles a key of the page; false if it is not a key of the player or text is being edited.
  press(event: KeyboardEvent): boolean {
    if (event.ctrlKey || event.altKey || event.metaKey || isEditing(event.target)) return false;
    if (event.key === ' ' && takesSpace(event.target)) return false;
    // A slider goes to its own ends.
    const isSlider = event.target instanceof HTMLInputElement && event.target.type === 'range';
    if (isSlider && (event.key === 'Home' || event.key === 'End')) return false;
    if (!this.keys.checked && (event.key === ',' || event.key === '.')) return false;
    if (event.key === ' ') this.clock.toggle();
    else if (event.key === ',') this.clock.step(-1);
    else if (event.key === '.') this.clock.step(1);
    else if (event.key === 'Home') this.clock.seek(0);
    else if (event.key === 'End') this.clock.seek(this.clock.duration);
    else return false;
    event.preventDefault();
    return true;
  }

  dispose(): void {
    this.remove();
  }

  private stepButton(label: string, text: string, frames: number): HTMLButtonElement {
    return button(
      text,
      () => {
        this.clock.step(frames);
      },
      { 'aria-label': label, title: label },
    );
  }

  private draw(): void {
    const { clock } = this;
    if (clock.playing !== this.shownPlaying) {
      this.shownPlaying = clock.playing;
      this.playButton.textContent = clock.playing ? 'Pause' : 'Play';
    }
    const last = Math.max(0, Math.round(clock.duration * clock.frameRate) - 1);
    if (this.slider.max !== String(last)) {
      this.slider.max = String(last);
      this.shownFrame = -1;
    }
    const now = performance.now();
    const early = clock.playing && now - this.drawnAt < kDrawMilliseconds;
    if (clock.frame === this.shownFrame || early) return;
    this.drawnAt = now;
    this.shownFrame = clock.frame;
    this.slider.value = String(clock.frame);
    this.slider.setAttribute('aria-valuetext', `frame ${clock.frame}`);
    this.position.textContent = `${clockText(clock.time)} / ${clockText(clock.duration)}, frame ${clock.frame}`;
  }
}

// True for a control that Space operates.
function takesSpace(target: EventTarget | null): boolean {
  return (
    target instanceof Element && target.closest('button, summary, input[type=checkbox]') !== null
  );
}

// True for a control that takes text or keys of its own.
export function isEditing(target: EventTarget | null): boolean {
  return (
    target instanceof HTMLTextAreaElement ||
    target instanceof HTMLSelectElement ||
    (target instanceof HTMLInputElement && target.type !== 'checkbox' && target.type !== 'range')
  );
}
