import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { UploadClipResponseSchema } from '../../api/messages';
import { Disposer } from '../../dom/disposer';
import type { ViewContext } from '../../shell/view';
import { UploadPanel } from './upload_panel';

// A panel to which three files are dropped, with the names of those that it has read. `answer` ends
// the check of the first one.
function dropThree() {
  const read: string[] = [];
  const files = ['a.bvh', 'b.bvh', 'c.bvh'].map((name) => ({
    name,
    size: 1,
    arrayBuffer: () => {
      read.push(name);
      return Promise.resolve(new ArrayBuffer(1));
    },
  }));
  let answer: () => void = () => undefined;
  const uploadClip = vi
    .fn(() => Promise.resolve(create(UploadClipResponseSchema)))
    .mockImplementationOnce(
      () =>
        new Promise((resolve) => {
          answer = () => {
            resolve(create(UploadClipResponseSchema));
          };
        }),
    );
  const context = { api: { clips: { uploadClip } } } as unknown as ViewContext;
  const disposer = new Disposer();
  const panel = new UploadPanel(context, 'demo', disposer, vi.fn());
  const drop = Object.assign(new Event('drop'), { dataTransfer: { files, types: ['Files'] } });
  document.dispatchEvent(drop);
  return {
    panel,
    read,
    disposer,
    uploadClip,
    answer: () => {
      answer();
    },
  };
}

// Waits until the check of the first file runs.
async function begun({ uploadClip }: ReturnType<typeof dropThree>) {
  await vi.waitFor(() => {
    expect(uploadClip).toHaveBeenCalledTimes(1);
  });
}

const settled = () => new Promise((resolve) => setTimeout(resolve, 20));

test('a closed panel reads none of its files', async () => {
  const dropped = dropThree();
  await begun(dropped);
  dropped.disposer.dispose();
  dropped.answer();
  await settled();
  expect(dropped.read).toEqual(['a.bvh']);
});

test('a removed file is not read', async () => {
  const dropped = dropThree();
  await begun(dropped);
  const removes = [...dropped.panel.node.querySelectorAll('button')].filter(
    ({ textContent }) => textContent === 'Remove',
  );
  removes[1]!.click();
  dropped.answer();
  await vi.waitFor(() => {
    expect(dropped.uploadClip).toHaveBeenCalledTimes(2);
  });
  expect(dropped.read).toEqual(['a.bvh', 'c.bvh']);
  dropped.disposer.dispose();
});

test('text can be dragged into an input, and files are taken', () => {
  const disposer = new Disposer();
  const context = { api: { clips: { uploadClip: vi.fn() } } } as unknown as ViewContext;
  const panel = new UploadPanel(context, 'demo', disposer, vi.fn());
  const isTaken = (type: string, types: string[]) => {
    const event = new Event(type, { cancelable: true });
    document.dispatchEvent(Object.assign(event, { dataTransfer: { types, files: [] } }));
    return event.defaultPrevented;
  };
  expect([isTaken('dragover', ['text/plain']), isTaken('drop', ['text/plain'])]).toEqual([
    false,
    false,
  ]);
  expect(panel.node.classList.contains('drop')).toBe(false);
  expect(isTaken('dragover', ['Files'])).toBe(true);
  expect(panel.node.classList.contains('drop')).toBe(true);
  expect(isTaken('drop', ['Files'])).toBe(true);
  disposer.dispose();
});
