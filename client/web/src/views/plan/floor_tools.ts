import { arrowOf } from '../../dom/arrow_keys';
import { button, element } from '../../dom/element';
import type { FloorXY } from './floor_geometry';

// A tool that places a pose.
export type PoseTool = 'start' | 'goal';
export type FloorTool = PoseTool | 'disc' | 'polygon' | 'choose' | 'move';

// Tool, key, text.
export const kTools: readonly (readonly [FloorTool, string, string])[] = [
  ['start', 's', 'Start: click, drag for the heading'],
  ['goal', 'g', 'Goal: click, drag for the heading'],
  ['disc', 'd', 'Disc: drag from its centre'],
  ['polygon', 'p', 'Polygon: click corners, Enter ends'],
  ['choose', 'c', 'Choose an obstacle'],
  ['move', 'm', 'Move the floor'],
];
// Tools for which keys move a cursor.
export const kCursorTools: readonly FloorTool[] = ['disc', 'polygon', 'choose'];
export const kKeys =
  'S, G, D, P, C, M: tool. Arrow keys: move start, goal or floor, or for obstacles the cursor. ' +
  '[ and ]: turn start or goal, or change the disc. Space: add a corner, or choose. Enter: end the ' +
  'obstacle. Delete: remove the last corner, or an obstacle. Escape: drop what is drawn. ' +
  '+ and -: zoom.';
// The step of an arrow key; undefined for other keys.
export function stepOf(key: string): FloorXY | undefined {
  const arrow = arrowOf(key);
  return arrow && { x: 0.1 * arrow.up, y: -0.1 * arrow.right };
}

export function isPoseTool(tool: FloorTool): tool is PoseTool {
  return tool === 'start' || tool === 'goal';
}

export interface ToolbarActions {
  choose: (tool: FloorTool) => void;
  remove: () => void;
  fit: () => void;
  // 1: closer, -1: farther.
  zoom: (steps: number) => void;
}

// The buttons above the floor.
export class FloorToolbar {
  readonly node = element('div', {
    class: 'row',
    role: 'toolbar',
    'aria-label': 'Tools of the floor',
  });
  private readonly buttons = new Map<FloorTool, HTMLButtonElement>();

  constructor(actions: ToolbarActions) {
    for (const [tool, , text] of kTools) {
      const node = button(text, () => {
        actions.choose(tool);
      });
      this.buttons.set(tool, node);
      this.node.append(node);
    }
    const zoomButton = (text: string, label: string, steps: number) =>
      button(
        text,
        () => {
          actions.zoom(steps);
        },
        { 'aria-label': label },
      );
    this.node.append(
      button('Remove obstacle', actions.remove),
      button('Show all', actions.fit),
      zoomButton('+', 'Zoom in', 1),
      zoomButton('-', 'Zoom out', -1),
    );
  }

  show(tool: FloorTool): void {
    for (const [name, node] of this.buttons)
      node.setAttribute('aria-pressed', String(name === tool));
  }
}

export function describeKeys(): HTMLElement {
  const summary = element('summary', {}, 'Keys of the floor');
  return element('details', { class: 'hint' }, summary, kKeys);
}
