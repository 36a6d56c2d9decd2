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
