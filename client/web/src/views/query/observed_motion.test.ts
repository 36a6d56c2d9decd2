import { expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { observeFiles } from './observed_motion';

test('a motion that is larger than any request is not read', async () => {
  const arrayBuffer = vi.fn();
  const file = { name: 'walk.bvh', size: 2 ** 31, arrayBuffer } as unknown as File;
  const asked = observeFiles({} as Api, 'demo', [file], new AbortController().signal);
  await expect(asked).rejects.toThrow('walk.bvh: expected at most 1,024 MiB');
  expect(arrayBuffer).not.toHaveBeenCalled();
});
