import { element } from './element';
import { count } from './format';

// The largest value of --max-message-mib. The page does not know that of the server, which refuses
// a smaller file if necessary; a larger one would only exhaust the memory of the tab.
const kMaxMebibytes = 1024;

// Reads a file that the user has chosen. Throws without reading it if no server would take it.
export async function readFile(file: File): Promise<Uint8Array<ArrayBuffer>> {
  const mebibytes = file.size / 2 ** 20;
  if (mebibytes > kMaxMebibytes) {
    throw new Error(
      `${file.name}: expected at most ${count(kMaxMebibytes)} MiB (largest max-message-mib of a ` +
        `server), got ${count(Math.ceil(mebibytes))} MiB.`,
    );
  }
  return new Uint8Array(await file.arrayBuffer());
}

// Lets the browser store bytes as a file.
export function downloadBytes(
  fileName: string,
  parts: readonly (Uint8Array | Blob)[],
  type = 'application/octet-stream',
): void {
  const url = URL.createObjectURL(new Blob([...parts] as BlobPart[], { type }));
  const link = element('a', { href: url, download: fileName });
  link.click();
  setTimeout(URL.revokeObjectURL.bind(URL, url), 60_000);
}
