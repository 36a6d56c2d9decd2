import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import { GetServerStatusResponseSchema } from '../../api/messages';
import { statusFacts, StatusHistory } from './status_values';

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

const status = (calls: number, cpu: number) =>
  create(GetServerStatusResponseSchema, {
    callCount: BigInt(calls),
    cpuTime: { seconds: BigInt(Math.floor(cpu)), nanos: Math.round((cpu % 1) * 1e9) },
    memoryBytes: BigInt(2 ** 20),
  });

test('rates are differences over time, and none after a restart', () => {
  const history = new StatusHistory();
  history.add(status(100, 1), 10);
  history.add(status(150, 2.5), 12);
  history.add(status(3, 0.1), 14);
  expect(history.callsPerSecond).toEqual([null, 25, null]);
  expect(history.cpu).toEqual([null, 0.75, null]);
  expect(history.memoryMib).toEqual([1, 1, 1]);
});

test('keeps a bounded number of samples', () => {
  const history = new StatusHistory();
  for (let index = 0; index < 1000; ++index) history.add(status(index, index), index);
  expect(history.times.length).toBe(300);
  expect(history.cpu.length).toBe(300);
});
