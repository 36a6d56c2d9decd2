import { element } from './element';

// Lets the browser store bytes as a file.
export function downloadBytes(
  fileName: string,
  parts: readonly (Uint8Array | Blob)[],
  type = 'application/octet-stream',
): void {
  const url = URL.createObjectURL(new Blob([...parts] as BlobPart[], { type }));
  const link = element('a', { href: url, download: fileName });
  link.click();
  setTimeout(() => {
    URL.revokeObjectURL(url);
  }, 60_000);
}
