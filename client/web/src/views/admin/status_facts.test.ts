import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { GetServerStatusResponseSchema } from '../../api/messages';
import { statusFacts } from './status_facts';

test('the newest values of the charts are there as text', () => {
  const status = create(GetServerStatusResponseSchema, {
    memoryBytes: 96n * 1024n * 1024n,
    openCallCount: 7,
  });
  const textOf = (cores: number | null) => Object.fromEntries(statusFacts(status, cores));
  expect(textOf(1.256)).toMatchObject({
    Memory: '96.0 MiB',
    'Open calls': '7',
    'Processor cores in use': '1.26',
  });
  expect(textOf(null)['Processor cores in use']).toBe('not known yet');
  expect(textOf(null)).not.toHaveProperty('Corrupt items');
});
