// The database `many`: 200 different clips, parts of recorded motion of 1 s to 22 s.
import { mkdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { bvhOf, readBvh } from './bvh.mjs';
import { call, motiondb } from './server.mjs';
import { setup } from './setup.mjs';
import { stream } from './stream.mjs';

export const kManyClips = 200;
const kRecordings = [
  ['01_01', 'jump'],
  ['01_03', 'climb'],
  ['Boxing_Toes', 'boxing'],
];
const kShortest = 1; // s
const kLongest = 22;

// The i-th of numbers spread evenly over 0 to 1.
const spread = (i, step) => (i * step) % 1;

let stored;

// Stores the clips at the first call, without waiting for the model. Returns the name of each, and the
// MiB of its motion in a page.
export function storeManyClips() {
  stored ??= store();
  return stored;
}

async function store() {
  const folder = join(setup.folder, 'many');
  const recordings = await Promise.all(kRecordings.map(([name]) => readBvh(name)));
  for (const [, label] of kRecordings) await mkdir(join(folder, label), { recursive: true });
  for (let i = 0; i < kManyClips; ++i) {
    const recording = recordings[i % recordings.length];
    const { rows, rateHz } = recording;
    // As many clips of 1 s to 2 s as of 10 s to 20 s.
    const seconds = kShortest * (kLongest / kShortest) ** spread(i, Math.SQRT2 - 1);
    const length = Math.round(seconds * rateHz);
    const first = Math.round(spread(i, (Math.sqrt(5) - 1) / 2) * (rows.length - length));
    const name = `part_${String(i).padStart(3, '0')}.bvh`;
    const text = bvhOf(recording, rows.slice(first, first + length));
    await writeFile(join(folder, kRecordings[i % recordings.length][1], name), text);
  }
  await motiondb('create', 'many', '--frame-rate', '120');
  await motiondb('ingest', 'many', folder, '--label-from', '{label}/*', '--no-wait', '--quiet');
  const { body } = await call(setup.open, 'ClipService/ListClips', {
    parent: 'databases/many',
    pageSize: 1000,
  });
  // Neighbours have different bodies.
  const sizes = await Promise.all(
    body.clips.slice(0, kRecordings.length).map(({ name }) => bytesOfFrame(name)),
  );
  return body.clips.map(({ name, frameCount }, i) => ({
    name: name.split('/').at(-1),
    mebibytes: (frameCount * sizes[i % sizes.length]) / 2 ** 20,
  }));
}

// Bytes of a frame in a page: positions of markers and joints, and contacts.
async function bytesOfFrame(name) {
  const [{ figure }] = await stream(setup.open, 'ViewService/ReadClipMotion', {
    name,
    frameCount: 1,
    joints: true,
  });
  return 12 * (figure.markerNames.length + figure.jointNames.length) + 1;
}

// The operation that updates the model of `many`; undefined if it is done.
export async function modelOperation() {
  const { body } = await call(setup.open, 'OperationService/ListOperations', {
    parent: 'databases/many',
    pageSize: 1,
  });
  return (body.operations ?? []).find(({ state }) => /PENDING|RUNNING/.test(state));
}

// Memory and lists need no model.
export async function cancelModel() {
  const operation = await modelOperation();
  if (operation)
    await call(setup.open, 'OperationService/CancelOperation', { name: operation.name });
}
