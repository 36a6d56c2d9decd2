import { create } from '@bufbuild/protobuf';
import { Code, ConnectError } from '@connectrpc/connect';
import { expect, test, vi } from 'vitest';
import type { Api } from '../api/api';
import { Connection } from '../api/connection';
import {
  SegmentSchema,
  SegmentSource,
  WatchDatabaseResponseSchema,
  type ListSegmentsResponse,
} from '../api/messages';
import { PlaybackClock } from '../player/playback_clock';
import { SegmentPanel } from './segment_panel';

const clip = 'databases/demo/clips/a';

// A panel whose server has these calls.
function panelOf(segments: object): SegmentPanel {
  return new SegmentPanel({
    api: { segments } as unknown as Api,
    connection: new Connection(() => Promise.resolve()),
    clip,
    clock: new PlaybackClock(1, 60),
    editable: true,
    signal: new AbortController().signal,
    operation: () => undefined,
  });
}

// A panel, and the calls that read its segments; each ends when it is answered.
async function openPanel() {
  const answers: (() => void)[] = [];
  const listSegments = () =>
    new Promise<Partial<ListSegmentsResponse>>((resolve) => {
      answers.push(() => {
        resolve({ segments: [], nextPageToken: '' });
      });
    });
  const panel = panelOf({ listSegments });
  const turn = () => new Promise((resolve) => setTimeout(resolve, 0));
  await turn();
  const answer = async (call: number) => {
    await turn();
    answers[call]?.();
    await turn();
  };
  return { panel, answers, answer };
}

const changeOf = (name: string) =>
  create(WatchDatabaseResponseSchema, {
    change: { case: 'segment', value: create(SegmentSchema, { name, etag: 'new' }) },
  });

test('missed changes are read after the call that runs, once', async () => {
  const { panel, answers, answer } = await openPanel();
  panel.follow([]);
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  expect(answers.length).toBe(1);
  await answer(0);
  expect(answers.length).toBe(2);
  await answer(1);
  expect(answers.length).toBe(2);
});

test('changes that arrive while a call runs are read after it, if they are of the clip', async () => {
  const { panel, answers, answer } = await openPanel();
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  await answer(0);
  expect(answers.length).toBe(1);
  panel.follow([]);
  panel.follow([changeOf('databases/demo/clips/b/segments/1')]);
  panel.follow([changeOf(`${clip}/segments/1`)]);
  await answer(1);
  expect(answers.length).toBe(3);
});

test('a second edit before the answer of the first is no conflict', async () => {
  let etag = 1;
  const stored = () => ({
    name: `${clip}/segments/1`,
    track: 'action',
    label: 'walk',
    startSeconds: 0.1,
    endSeconds: 0.5,
    etag: String(etag),
    source: SegmentSource.PERSON,
    author: '',
  });
  type Update = { segment: { etag: string }; updateMask: { paths: string[] } };
  const updateSegment = vi.fn(async ({ segment }: Update) => {
    await new Promise((resolve) => setTimeout(resolve, 5));
    if (segment.etag !== String(etag)) throw new ConnectError('conflict', Code.Aborted);
    ++etag;
    return { segment: stored() };
  });
  const panel = panelOf({
    listSegments: () => Promise.resolve({ segments: [stored()], nextPageToken: '' }),
    updateSegment,
  });
  await new Promise((resolve) => setTimeout(resolve, 0));
  panel.node.querySelector<HTMLElement>('.segment-body')?.click();
  const edge = panel.node.querySelector('.edge.end');
  for (let i = 0; i < 3; ++i) {
    for (const kind of ['keydown', 'keyup'])
      edge?.dispatchEvent(new KeyboardEvent(kind, { key: 'ArrowRight', bubbles: true }));
  }
  await new Promise((resolve) => setTimeout(resolve, 50));
  expect(updateSegment).toHaveBeenCalledTimes(3);
  // Only the edge that moved is sent.
  expect(updateSegment.mock.calls.map(([{ updateMask }]) => updateMask.paths)).toEqual(
    Array.from({ length: 3 }, () => ['end_seconds']),
  );
  expect(panel.node.querySelector('.notice.error:not([hidden])')).toBeNull();
});
