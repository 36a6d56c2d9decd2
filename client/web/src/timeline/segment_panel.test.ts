import { create } from '@bufbuild/protobuf';
import { expect, test } from 'vitest';
import type { Api } from '../api/api';
import { Connection } from '../api/connection';
import {
  SegmentSchema,
  WatchDatabaseResponseSchema,
  type ListSegmentsResponse,
} from '../api/messages';
import { PlaybackClock } from '../player/playback_clock';
import { SegmentPanel } from './segment_panel';

const clip = 'databases/demo/clips/a';

// A panel, and the calls that read its segments; each ends when it is answered.
function openPanel() {
  const answers: (() => void)[] = [];
  const listSegments = () =>
    new Promise<Partial<ListSegmentsResponse>>((resolve) => {
      answers.push(() => {
        resolve({ segments: [], nextPageToken: '' });
      });
    });
  const panel = new SegmentPanel({
    api: { segments: { listSegments } } as unknown as Api,
    connection: new Connection(() => Promise.resolve()),
    clip,
    clock: new PlaybackClock(1, 60),
    editable: true,
    signal: new AbortController().signal,
    operation: () => undefined,
  });
  const answer = async (call: number) => {
    answers[call]?.();
    await new Promise((resolve) => setTimeout(resolve, 0));
  };
  return { panel, answers, answer };
}

const changeOf = (name: string) =>
  create(WatchDatabaseResponseSchema, {
    change: { case: 'segment', value: create(SegmentSchema, { name, etag: 'new' }) },
  });

test('missed changes are read after the call that runs, once', async () => {
  const { panel, answers, answer } = openPanel();
  panel.follow([]);
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  expect(answers.length).toBe(1);
  await answer(0);
  expect(answers.length).toBe(2);
  await answer(1);
  expect(answers.length).toBe(2);
});

test('changes that arrive while a call runs are read after it, if they are of the clip', async () => {
  const { panel, answers, answer } = openPanel();
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  await answer(0);
  expect(answers.length).toBe(1);
  panel.follow([]);
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  panel.follow([changeOf(`${clip}/segments/1`)]);
  await answer(1);
  expect(answers.length).toBe(3);
});
