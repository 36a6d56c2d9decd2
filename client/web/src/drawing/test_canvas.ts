// Records what is drawn on canvases, for unit tests: jsdom draws nothing.
import { vi } from 'vitest';

export interface DrawnRectangle {
  x: number;
  y: number;
  width: number;
  height: number;
  color: string;
}

// The rectangles that are on the canvas, in the order of drawing. For tests with one canvas.
export function recordRectangles(): DrawnRectangle[] {
  const drawn: DrawnRectangle[] = [];
  const context = {
    fillStyle: '',
    clearRect: () => {
      drawn.length = 0;
    },
    fillRect: (x: number, y: number, width: number, height: number) => {
      drawn.push({ x, y, width, height, color: context.fillStyle });
    },
  };
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockReturnValue(context as never);
  return drawn;
}
