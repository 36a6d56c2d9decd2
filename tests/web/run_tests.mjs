// Runs test files one after the other, in one process with one browser: run_tests.mjs NAME...
import { test } from 'node:test';

for (const name of process.argv.slice(2)) {
  test(`== ${name}`, () => {});
  await import(`./${name}.test.mjs`);
}
