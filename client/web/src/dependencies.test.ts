import { expect, test } from 'vitest';
import manifest from '../package.json?raw';

const sources = import.meta.glob<string>(['./**/*.ts', '!./**/*.test.ts'], {
  query: '?raw',
  import: 'default',
  eager: true,
});

test('every package that the page depends on is imported', () => {
  const { dependencies } = JSON.parse(manifest) as { dependencies: Record<string, string> };
  const texts = Object.values(sources);
  const unused = Object.keys(dependencies).filter(
    (name) => !texts.some((text) => text.includes(`'${name}'`) || text.includes(`'${name}/`)),
  );
  expect(unused).toEqual([]);
});
