// A server of one test, which the test can stop and start again.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { createInterface } from 'node:readline';
import { setup } from './setup.mjs';

export class OwnServer {
  // `store`: path of its file.
  constructor(store) {
    this.store = store;
    this.url = 'http://127.0.0.1:0';
  }

  // Starts it, with more options; after a stop with the same address.
  async start(...more) {
    const options = [
      '--store',
      this.store,
      '--listen',
      '127.0.0.1:0',
      '--log-level',
      'error',
      ...more,
    ];
    const web = ['--web-listen', new URL(this.url).host];
    this.process = spawn(setup.motiondbd, [...options, ...web], {
      stdio: ['ignore', 'pipe', 'inherit'],
    });
    for await (const line of createInterface({ input: this.process.stdout })) {
      const address = line.trim().split(' ').at(-1);
      if (line.startsWith('motiondbd: HTTP API at ')) this.url = address;
      if (!line.startsWith('motiondbd: listening on ')) continue;
      this.address = address;
      return;
    }
    throw new Error('expected a server that listens, got one that ended');
  }

  async stop(signal = 'SIGTERM') {
    const { process } = this;
    this.process = undefined;
    if (!process || process.exitCode !== null) return;
    process.kill(signal);
    await once(process, 'exit');
  }
}
