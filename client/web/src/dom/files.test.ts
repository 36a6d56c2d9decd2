import { expect, test, vi } from 'vitest';
import { readFile } from './files';

// A file that only says how large it is.
function fileOf(size: number) {
  const arrayBuffer = vi.fn(() => Promise.resolve(Uint8Array.of(7).buffer));
  return { file: { name: 'walk.bvh', size, arrayBuffer } as unknown as File, arrayBuffer };
}

test('a file as large as the largest request is read', async () => {
  expect(await readFile(fileOf(2 ** 30).file)).toEqual(Uint8Array.of(7));
});

test('a larger file is refused before it is read', async () => {
  const { file, arrayBuffer } = fileOf(2 ** 30 + 1);
  await expect(readFile(file)).rejects.toThrow('walk.bvh: expected at most 1,024 MiB');
  await expect(readFile(file)).rejects.toThrow('got 1,025 MiB');
  expect(arrayBuffer).not.toHaveBeenCalled();
});
