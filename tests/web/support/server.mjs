// Calls to the servers without a browser.
import { execFile } from 'node:child_process';
import { promisify } from 'node:util';
import { setup } from './setup.mjs';

// Calls an RPC with JSON, as the administrator: call(setup.secure, 'DatabaseService/ListDatabases', {}).
export async function call(server, method, request, headers = {}) {
  const response = await fetch(`${server}/motiondb.v1.${method}`, {
    method: 'POST',
    headers: {
      'content-type': 'application/json',
      authorization: `Bearer ${setup.adminToken}`,
      ...headers,
    },
    body: JSON.stringify(request),
  });
  return { status: response.status, body: await response.json() };
}

// Creates a token; returns its name and its secret.
export async function createToken(role, database = '') {
  const { status, body } = await call(setup.secure, 'AccessService/CreateToken', {
    token: { role, database },
  });
  if (status !== 200) throw new Error(JSON.stringify(body));
  return { name: body.token.name, secret: body.secret };
}

export async function revokeToken(name) {
  const { status, body } = await call(setup.secure, 'AccessService/RevokeToken', { name });
  if (status !== 200) throw new Error(JSON.stringify(body));
}

// Runs the command line against the open server; returns its output.
export async function motiondb(...command) {
  const run = promisify(execFile);
  return (await run(setup.motiondb, ['--server', setup.openAddress, ...command])).stdout;
}
