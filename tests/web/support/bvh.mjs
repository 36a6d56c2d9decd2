// BVH files with other frames than the recorded ones.
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { setup } from './setup.mjs';

// A file of a folder: its lines before the number of frames, the line of the frame time, one line
// for each frame, and the frame rate.
export async function readBvh(name, folder = setup.models) {
  const lines = (await readFile(join(folder, `${name}.bvh`))).toString().split('\n');
  const begin = lines.findIndex((line) => line.startsWith('Frames:'));
  const time = lines[begin + 1];
  const rows = lines.slice(begin + 2).filter((line) => line.trim() !== '');
  return { head: lines.slice(0, begin), time, rows, rateHz: 1 / Number(time.split(':')[1]) };
}

// The text of a file with the same body and these frames.
export function bvhOf({ head, time }, rows) {
  return [...head, `Frames: ${rows.length}`, time, ...rows, ''].join('\n');
}
