// The direction of an arrow key: 1 to the right and up, -1 to the left and down.
export interface Arrow {
  right: number;
  up: number;
}

const kArrows: ReadonlyMap<string, Arrow> = new Map([
  ['ArrowLeft', { right: -1, up: 0 }],
  ['ArrowRight', { right: 1, up: 0 }],
  ['ArrowUp', { right: 0, up: 1 }],
  ['ArrowDown', { right: 0, up: -1 }],
]);

// Undefined for other keys.
export function arrowOf(key: string): Arrow | undefined {
  return kArrows.get(key);
}
