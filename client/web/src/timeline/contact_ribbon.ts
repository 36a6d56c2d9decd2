import { element } from '../dom/element';
import type { ThemeSwitch } from '../shell/theme';

const kWidth = 1200;
const kHeight = 16;

// When the feet stand, as two stripes over time: left above, right below.
export class ContactRibbon {
  readonly node: HTMLElement;
  private readonly canvas = element('canvas', { width: kWidth, height: kHeight });
  private readonly remove: () => void;
  private contacts = new Uint8Array(0);

  constructor(private readonly theme: ThemeSwitch) {
    this.node = element(
      'div',
      {
        class: 'contacts',
        role: 'img',
        'aria-label': 'Times when the left and the right foot stand',
      },
      element('span', { class: 'track-name', 'aria-hidden': 'true' }, 'feet'),
      this.canvas,
    );
    this.remove = theme.onChange(() => {
      this.draw(this.contacts);
    });
  }

  // One byte a frame: bit 0 left, bit 1 right.
  draw(contacts: Uint8Array): void {
    this.contacts = new Uint8Array(contacts);
    const context = this.canvas.getContext('2d');
    if (!context || contacts.length === 0) return;
    context.clearRect(0, 0, kWidth, kHeight);
    for (const foot of [0, 1]) {
      context.fillStyle = this.theme.color(foot === 0 ? '--left' : '--right');
      for (const [begin, end] of runsOf(contacts, 1 << foot)) {
        const x = (begin * kWidth) / contacts.length;
        const width = Math.max(1, ((end - begin) * kWidth) / contacts.length);
        context.fillRect(x, (foot * kHeight) / 2, width, kHeight / 2 - 1);
      }
    }
  }

  dispose(): void {
    this.remove();
  }
}

// Runs [begin, end) of bytes with a bit.
export function runsOf(bytes: Uint8Array, bit: number): [number, number][] {
  const runs: [number, number][] = [];
  let begin = -1;
  for (let index = 0; index <= bytes.length; ++index) {
    const set = index < bytes.length && ((bytes[index] ?? 0) & bit) !== 0;
    if (set && begin < 0) begin = index;
    if (!set && begin >= 0) {
      runs.push([begin, index]);
      begin = -1;
    }
  }
  return runs;
}
