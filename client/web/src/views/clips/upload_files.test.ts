import { expect, test } from 'vitest';
import { uploadJobs } from './upload_files';

const files = (...names: string[]) => names.map((name) => ({ name }));

test('a skeleton goes with the motions that begin with its name', () => {
  const jobs = uploadJobs(files('07.asf', '07_01.amc', '08.asf', '08_02.amc', 'walk.bvh'));
  expect(jobs.map((job) => [job.motion.name, job.skeleton?.name])).toEqual([
    ['07_01.amc', '07.asf'],
    ['08_02.amc', '08.asf'],
    ['walk.bvh', undefined],
  ]);
});

test('the only skeleton goes with all motions of its kind', () => {
  const jobs = uploadJobs(files('g1.urdf', 'dance.csv', 'walk.amc'));
  expect(jobs.map((job) => job.skeleton?.name)).toEqual(['g1.urdf', undefined]);
});
