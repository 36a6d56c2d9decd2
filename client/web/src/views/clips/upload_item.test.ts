import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import {
  MarkerSetSchema,
  UploadClipResponseSchema,
  type UploadClipRequest,
} from '../../api/messages';
import type { ViewContext } from '../../shell/view';
import { MappingEditor } from './mapping_editor';
import { UploadItem } from './upload_item';

// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));

type Upload = Pick<UploadClipRequest, 'header'>;

// The answer to a check of a file with one joint.
const checkedAs = (mapping: string) =>
  create(UploadClipResponseSchema, {
    clip: { name: 'databases/demo/clips/a' },
    mapping,
    mappingText: 'Head = skull\n',
    points: [{ name: 'skull', markerNames: ['Head'] }],
  });

function itemOf(uploadClip: (request: Upload) => Promise<unknown>) {
  const markerSet = create(MarkerSetSchema, { markerNames: ['Head'] });
  const markerSets = {
    getMarkerSet: () => Promise.resolve({ markerSet }),
    addMappings: vi.fn(() => Promise.resolve({})),
  };
  const api = { clips: { uploadClip: vi.fn(uploadClip) }, markerSets };
  const events = { stored: vi.fn(), changed: vi.fn(), closed: vi.fn() };
  const motion = { name: 'a.bvh', size: 1, arrayBuffer: () => Promise.resolve(new ArrayBuffer(1)) };
  const job = { motion: motion as File, skeleton: undefined };
  const item = new UploadItem({ api } as unknown as ViewContext, 'demo', job, events);
  document.body.replaceChildren(item.node);
  const buttonOf = (text: string) => {
    const buttons = [...item.node.querySelectorAll('button')];
    return buttons.find((node) => node.textContent === text)!;
  };
  const inputOf = (label: string) => {
    const labels = [...item.node.querySelectorAll('label')];
    return labels.find((node) => node.textContent === label)!.querySelector('input')!;
  };
  return { item, api, buttonOf, inputOf };
}

type Item = ReturnType<typeof itemOf>;

// The input of the rule of the only marker.
async function ruleOf({ item }: Item): Promise<HTMLInputElement> {
  return vi.waitFor(() => {
    const input = item.node.querySelector<HTMLInputElement>('[aria-label="Rule of Head"]');
    expect(input).not.toBeNull();
    return input!;
  });
}

function edit(input: HTMLInputElement, value: string) {
  input.value = value;
  input.dispatchEvent(new Event('input'));
}

const hintsOf = ({ item }: Item) =>
  [...item.node.querySelectorAll<HTMLElement>('[role=status].hint')].filter((hint) =>
    /not used yet/.test(hint.textContent),
  );

test('a clip is not stored with rules that are edited and not used', async () => {
  const opened = itemOf(() => Promise.resolve(checkedAs('robot')));
  const { item, api, buttonOf } = opened;
  await item.check(true);
  const rule = await ruleOf(opened);
  const state = () => [buttonOf('Store').disabled, item.isReady, hintsOf(opened)[0]?.hidden];
  expect(state()).toEqual([false, true, true]);
  edit(rule, '0.5 skull');
  expect(state()).toEqual([true, false, false]);
  buttonOf('Reset rules').click();
  expect([rule.value, ...state()]).toEqual(['skull', false, true, true]);
  edit(rule, '0.5 skull');
  buttonOf('Use these rules').click();
  await vi.waitFor(() => {
    expect(state()).toEqual([false, true, true]);
  });
  expect(api.markerSets.addMappings).toHaveBeenCalledTimes(1);
  expect(api.clips.uploadClip).toHaveBeenCalledTimes(2);
  item.dispose();
});

test('a closed mapping has no figure and keeps its rules', async () => {
  const figure = [
    vi.spyOn(MappingEditor.prototype, 'showFigure'),
    vi.spyOn(MappingEditor.prototype, 'hideFigure'),
  ];
  const opened = itemOf(() => Promise.resolve(checkedAs('robot')));
  const { item } = opened;
  await item.check(true);
  const rule = await ruleOf(opened);
  edit(rule, '0.5 skull');
  const details = item.node.querySelector('details')!;
  const calls = () => figure.map((method) => method.mock.calls.length);
  for (const [open, expected] of [
    [false, [1, 1]],
    [true, [2, 1]],
  ] as const) {
    details.open = open;
    await vi.waitFor(() => {
      expect(calls()).toEqual(expected);
    });
  }
  expect((await ruleOf(opened)).value).toBe('0.5 skull');
  item.dispose();
});

test('the answer for the take before is dropped', async () => {
  const answers: ((take: string) => void)[] = [];
  const opened = itemOf(
    () =>
      new Promise((resolve) => {
        answers.push((take) => {
          resolve(checkedAs(take));
        });
      }),
  );
  const { item, inputOf, buttonOf, api } = opened;
  for (const take of ['A', 'B']) {
    inputOf('Take').value = take;
    inputOf('Take').dispatchEvent(new Event('change'));
  }
  await vi.waitFor(() => {
    expect(answers.length).toBe(2);
  });
  answers[1]!('mapping of B');
  await vi.waitFor(() => {
    expect(item.state).toBe('checked');
  });
  answers[0]!('mapping of A');
  await ruleOf(opened);
  expect(item.node.textContent).toContain('mapping of B');
  expect(item.node.textContent).not.toContain('mapping of A');
  // While it is stored, nothing changes the take or checks again.
  buttonOf('Store').click();
  expect(['Take', 'Label', 'Subject'].map((label) => inputOf(label).disabled)).toEqual([
    true,
    true,
    true,
  ]);
  inputOf('Take').dispatchEvent(new Event('change'));
  await vi.waitFor(() => {
    expect(answers.length).toBe(3);
  });
  answers[2]!('stored');
  await vi.waitFor(() => {
    expect(item.state).toBe('stored');
  });
  const sent = api.clips.uploadClip.mock.calls.map(([{ header }]) => [
    header?.validateOnly,
    header?.conventions?.take,
  ]);
  expect(sent).toEqual([
    [true, 'A'],
    [true, 'B'],
    [false, 'B'],
  ]);
  item.dispose();
});
