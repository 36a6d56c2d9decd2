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
const turn = () => new Promise((resolve) => setTimeout(resolve, 0));

// A panel whose server has these calls of segments and edits.
function panelOf(calls: object, clock = new PlaybackClock(1, 60)): SegmentPanel {
  return new SegmentPanel({
    api: { segments: calls, edits: calls } as unknown as Api,
    connection: new Connection(() => Promise.resolve()),
    clip,
    clock,
    editable: true,
    view: { zoom: 1, segment: '' },
    viewed: () => undefined,
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

const stored = (label: string, endSeconds: number, etag = '1') => ({
  name: `${clip}/segments/1`,
  track: 'action',
  label,
  startSeconds: 0.1,
  endSeconds,
  etag,
  source: SegmentSource.PERSON,
  author: '',
});

test('a second edit before the answer of the first is no conflict', async () => {
  let etag = 1;
  type Update = { segment: { etag: string }; updateMask: { paths: string[] } };
  const updateSegment = vi.fn(async ({ segment }: Update) => {
    await new Promise((resolve) => setTimeout(resolve, 5));
    if (segment.etag !== String(etag)) throw new ConnectError('conflict', Code.Aborted);
    ++etag;
    return { segment: stored('walk', 0.5, String(etag)) };
  });
  const panel = panelOf({
    listSegments: () => Promise.resolve({ segments: [stored('walk', 0.5)], nextPageToken: '' }),
    updateSegment,
  });
  await new Promise((resolve) => setTimeout(resolve, 0));
  panel.node.querySelector<HTMLElement>('.segment-body')?.click();
  const edge = panel.node.querySelector('.edge.end');
  for (let i = 0; i < 3; ++i) {
    for (const kind of ['keydown', 'keyup'])
      edge?.dispatchEvent(new KeyboardEvent(kind, { key: 'ArrowRight', bubbles: true }));
  }
  await vi.waitFor(() => {
    expect(etag).toBe(4); // three updates
  });
  // Only the edge that moved is sent.
  expect(updateSegment.mock.calls.map(([{ updateMask }]) => updateMask.paths)).toEqual(
    Array.from({ length: 3 }, () => ['end_seconds']),
  );
  expect(panel.node.querySelector('.notice.error:not([hidden])')).toBeNull();
});

// A panel with one segment, `1`, which is selected.
async function openSegment(calls: object = {}) {
  const state = { segments: [stored('walk', 0.5)] };
  const clock = new PlaybackClock(1, 60);
  const listSegments = () => Promise.resolve({ segments: state.segments, nextPageToken: '' });
  const panel = panelOf({ listSegments, ...calls }, clock);
  await turn();
  panel.node.querySelector<HTMLElement>('.segment-body')?.click();
  const press = async (text: string) => {
    const buttons = [...panel.node.querySelectorAll('button')];
    buttons.find((each) => each.textContent === text)?.click();
    await turn();
  };
  const label = () => panel.node.querySelector<HTMLInputElement>('.segment-form input')!;
  return { state, clock, panel, press, label };
}

test('the player repeats the selected segment where it is now, and all after it is deleted', async () => {
  const { state, clock, panel, press } = await openSegment({
    deleteSegment: () => Promise.resolve({}),
  });
  expect(clock.range).toEqual({ begin: 0.1, end: 0.5 });
  state.segments = [stored('walk', 0.75, '2')];
  panel.follow([]);
  await turn();
  expect(clock.range).toEqual({ begin: 0.1, end: 0.75 });
  await press('Delete');
  expect(clock.range).toBeNull();
});

test('typed text stays when another part of the segment is stored', async () => {
  const { panel, label, press } = await openSegment({
    updateSegment: ({ segment }: { segment: { label: string; endSeconds: number } }) =>
      Promise.resolve({ segment: stored(segment.label, segment.endSeconds, '2') }),
  });
  label().value = 'run';
  const edge = panel.node.querySelector('.edge.end');
  for (const kind of ['keydown', 'keyup'])
    edge?.dispatchEvent(new KeyboardEvent(kind, { key: 'ArrowRight', bubbles: true }));
  await turn();
  const texts = () =>
    [...panel.node.querySelectorAll<HTMLInputElement>('.segment-form input')].map(
      ({ value, defaultValue }) => [value, defaultValue],
    );
  expect(texts()).toEqual([
    ['run', 'walk'],
    ['0.100', '0.100'],
    ['0.517', '0.517'],
  ]);
  await press('Save');
  expect(texts()[0]).toEqual(['run', 'run']);
});

test('edits of the segments are undone one after the other, and no other edits', async () => {
  const edit = (id: number, ...names: string[]) => ({
    name: `databases/demo/edits/${id}`,
    objects: names.map((name) => ({ name })),
  });
  const [own, other] = [`${clip}/segments/1`, 'databases/demo/clips/b/segments/1'];
  const edits = [edit(4, clip), edit(3, own, other), edit(2, own, clip), edit(1, own)];
  const undone: string[] = [];
  const undoEdit = ({ name }: { name: string }) => {
    undone.push(name.split('/').at(-1)!);
    edits.unshift(edit(5 + undone.length, own));
    return Promise.resolve({ edit: edits[0] });
  };
  const listEdits = () => Promise.resolve({ edits });
  const { press, panel } = await openSegment({ listEdits, undoEdit });
  for (let i = 0; i < 3; ++i) await press('Undo last edit');
  expect(undone).toEqual(['2', '1']);
  expect(panel.node.textContent).toContain('no edits');
});
