import { arrowOf } from '../../dom/arrow_keys';
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
