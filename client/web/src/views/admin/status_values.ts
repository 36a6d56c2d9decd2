import type { GetServerStatusResponse } from '../../api/messages';
import { bytes, count, time } from '../../dom/format';

// The status of the server as names and texts. `cores`: processor cores in use since the status
// before; null if that is not known.
export function statusFacts(
  status: GetServerStatusResponse,
  cores: number | null,
): [name: string, text: string][] {
  const state =
    status.notReadyReason !== '' ? status.notReadyReason : status.serving ? 'serving' : 'draining';
  const facts: [string, string][] = [
    ['Version', status.version],
    ['Started', time(status.startTime)],
    ['State', state],
    ['Encryption', status.encrypted ? 'on' : 'off'],
    ['Authentication', status.authenticated ? 'required' : 'DISABLED'],
    ['Calls', `${count(status.callCount)}, ${count(status.failedCallCount)} with a server error`],
    ['Open calls', count(status.openCallCount)],
    ['Open streams', count(status.openStreamCount)],
    ['Memory', bytes(status.memoryBytes)],
    ['Processor cores in use', cores === null ? 'not known yet' : cores.toFixed(2)],
    ['Store', `${bytes(status.storeBytes)}, log ${bytes(status.logBytes)}`],
    ['Free disk space', status.diskBytes === undefined ? '' : bytes(status.diskFreeBytes)],
    [
      'Corrupt items',
      status.corruptions.map((each) => `${each.resource}: ${each.description}`).join('\n'),
    ],
  ];
  return facts.filter(([, text]) => text !== '');
}

const kMaxSamples = 300;

// Statistics of the server over the last polls, for charts.
export class StatusHistory {
  readonly times: number[] = [];
  readonly callsPerSecond: (number | null)[] = [];
  readonly failuresPerSecond: (number | null)[] = [];
  readonly cpu: (number | null)[] = [];
  readonly memoryMib: number[] = [];
  readonly openCalls: number[] = [];
  private last: { time: number; calls: number; failures: number; cpu: number } | undefined;

  // Adds the status read at `time`, in seconds. The first sample has no rates, and none after a
  // restart of the server either.
  add(status: GetServerStatusResponse, time: number): void {
    const now = {
      time,
      calls: Number(status.callCount),
      failures: Number(status.failedCallCount),
      cpu: Number(status.cpuTime?.seconds ?? 0n) + (status.cpuTime?.nanos ?? 0) / 1e9,
    };
    const before =
      this.last && now.calls >= this.last.calls && time > this.last.time ? this.last : undefined;
    const rate = (value: number, old: number | undefined) =>
      before === undefined || old === undefined ? null : (value - old) / (time - before.time);
    this.times.push(time);
    this.callsPerSecond.push(rate(now.calls, before?.calls));
    this.failuresPerSecond.push(rate(now.failures, before?.failures));
    this.cpu.push(rate(now.cpu, before?.cpu));
    this.memoryMib.push(Number(status.memoryBytes) / 2 ** 20);
    this.openCalls.push(status.openCallCount);
    this.last = now;
    if (this.times.length <= kMaxSamples) return;
    for (const values of [
      this.times,
      this.callsPerSecond,
      this.failuresPerSecond,
      this.cpu,
      this.memoryMib,
      this.openCalls,
    ]) {
      values.shift();
    }
  }
}
