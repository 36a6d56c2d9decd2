// Writes NAME.gz next to every text file of dist/ that gzip makes smaller by at least a tenth.
import { readdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { dirname, extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { constants, gzipSync } from 'node:zlib';

const dist = join(dirname(dirname(fileURLToPath(import.meta.url))), 'dist');
const compressible = new Set(['.css', '.html', '.js', '.json', '.svg', '.txt', '.wasm']);

for (const name of readdirSync(dist, { recursive: true })) {
  const path = join(dist, name);
  if (!compressible.has(extname(path)) || !statSync(path).isFile()) continue;
  const plain = readFileSync(path);
  const compressed = gzipSync(plain, { level: constants.Z_BEST_COMPRESSION });
  if (compressed.length < 0.9 * plain.length) writeFileSync(`${path}.gz`, compressed);
}
