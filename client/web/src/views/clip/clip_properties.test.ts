import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import { ClipSchema } from '../../api/messages';
import { ClipProperties } from './clip_properties';

test('properties that are saved twice are stored once, without a conflict', async () => {
  const clip = create(ClipSchema, { name: 'databases/demo/clips/a', etag: '1' });
  let answer: () => void = () => undefined;
  const updateClip = vi.fn(
    () =>
      new Promise((resolve) => {
        answer = () => {
          resolve({ clip: create(ClipSchema, { ...clip, etag: '2', title: 'Walk' }) });
        };
      }),
  );
  const announce = vi.fn();
  const { node } = new ClipProperties({
    api: { clips: { updateClip } } as unknown as Api,
    clip,
    editable: true,
    signal: new AbortController().signal,
    announce,
  });
  const edit = (title: string) => {
    [...node.querySelectorAll('button')].find((each) => each.textContent === 'Edit')?.click();
    const form = node.querySelector('form')!;
    form.querySelector('input')!.value = title;
    return () => form.dispatchEvent(new Event('submit', { cancelable: true }));
  };
  const save = edit('Walk');
  save();
  save();
  answer();
  await vi.waitFor(() => {
    expect(announce).toHaveBeenCalledTimes(1);
  });
  expect(updateClip).toHaveBeenCalledTimes(1);
  edit('Run')();
  expect(updateClip).toHaveBeenCalledTimes(2);
});
