// Generates the Connect client from proto/ with Debian's protoc and protoc-gen-es.
import { execFileSync } from 'node:child_process';
import { mkdirSync, readdirSync, rmSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const page = dirname(dirname(fileURLToPath(import.meta.url)));
const protos = join(page, '..', '..', 'proto');
const target = join(page, 'src', 'generated');

const files = readdirSync(join(protos, 'motiondb', 'v1'))
  .filter((name) => name.endsWith('.proto'))
  .map((name) => join(protos, 'motiondb', 'v1', name));

rmSync(target, { recursive: true, force: true });
mkdirSync(target, { recursive: true });
try {
  execFileSync(
    process.env.PROTOC ?? 'protoc',
    [
      `--plugin=protoc-gen-es=${join(page, 'node_modules', '.bin', 'protoc-gen-es')}`,
      `--es_out=${target}`,
      '--es_opt=target=ts',
      `--proto_path=${protos}`,
      ...files,
    ],
    { stdio: 'inherit' },
  );
} catch (error) {
  if (error.code !== 'ENOENT') throw error;
  console.error('expected protoc, found none; install the Debian package protobuf-compiler');
  process.exit(1);
}
