// The database `known`: 12 clips of 2 s, 3 labels with 4 subjects each, enough to calibrate the
// probability of unknown motion.
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { bvhOf, readBvh } from './bvh.mjs';
import { motiondb } from './server.mjs';
import { setup } from './setup.mjs';

const kRecordings = [
  ['01_01', 'jump'],
  ['01_03', 'climb'],
  ['Boxing_Toes', 'boxing'],
];
const kSubjects = ['a', 'b', 'c', 'd'];

let stored;

// Stores the clips at the first call, with their model: jump_a, ..., boxing_d.
export function storeKnown() {
  stored ??= store();
  return stored;
}

async function store() {
  const folder = join(setup.folder, 'known');
  for (const [file, label] of kRecordings) {
    const recording = await readBvh(file);
    const { rows, rateHz } = recording;
    for (const [i, subject] of kSubjects.entries()) {
      const first = Math.floor(((i + 0.2) * rows.length) / 4.3);
      const part = rows.slice(first, first + 2 * Math.round(rateHz));
      await mkdir(join(folder, subject, label), { recursive: true });
      await writeFile(
        join(folder, subject, label, `${label}_${subject}.bvh`),
        bvhOf(recording, part),
      );
    }
  }
  await motiondb('create', 'known');
  await motiondb('ingest', 'known', folder, '--label-from', '{subject}/{label}/*.bvh', '--quiet');
}
