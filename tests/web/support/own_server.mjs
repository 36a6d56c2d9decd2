// A server of one test, which the test can stop and start again.
import { execFile, spawn } from 'node:child_process';
import { once } from 'node:events';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { promisify } from 'node:util';
import { setup } from './setup.mjs';

const run = promisify(execFile);

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

  // Stores the database `own` with the clip 01_01.
  async fill() {
    const motiondb = (...command) => run(setup.motiondb, ['--server', this.address, ...command]);
    await motiondb('create', 'own');
    await motiondb('ingest', 'own', join(setup.models, '01_01.bvh'), '--label', 'jump');
  }

  async stop(signal = 'SIGTERM') {
    const { process } = this;
    this.process = undefined;
    if (!process || process.exitCode !== null) return;
    process.kill(signal);
    await once(process, 'exit');
  }
}
