// The files of a plan: those of the motion that is shown, and the robot.
import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { Connection } from '../../api/connection';
import { PlannedMotionSchema, PlanOutcome } from '../../api/messages';
import { floatBytes } from '../../motion/motion';
import type { ViewContext } from '../../shell/view';
import { open } from './plan_view';

const saved = vi.fn(() => 'blob:1');
vi.stubGlobal('URL', Object.assign(URL, { createObjectURL: saved, revokeObjectURL: vi.fn() }));
vi.spyOn(HTMLAnchorElement.prototype, 'click').mockImplementation(() => undefined);
// No WebGL.
vi.mock('../../scene/scene', () => ({ createScene: () => undefined }));
vi.stubGlobal(
  'ResizeObserver',
  class {
    observe = vi.fn();
    disconnect = vi.fn();
  },
);

function motionAt(height: number) {
  return create(PlannedMotionSchema, {
    frameCount: 1,
    frameRateHz: 60,
    markerNames: ['head'],
    markerPositions: floatBytes(Float32Array.of(0, 0, height)),
    file: { fileName: 'plan.csv', data: Uint8Array.of(1) },
  });
}

const answer = (motion: unknown) => ({ motion, alternatives: [], missing: '' });

function openPlan(plan: () => Promise<unknown>, goal = 'goal=2,1,0') {
  const context = {
    api: {
      clips: { listClips: () => Promise.resolve({ clips: [] }) },
      queries: { plan },
      views: { getFigure: () => Promise.resolve({ figure: { markerBones: [] } }) },
    },
    connection: new Connection(() => Promise.resolve()),
    theme: { name: 'light', onChange: () => () => undefined, color: () => '#000' },
    setQuery: vi.fn(),
    announce: vi.fn(),
  };
  const host = document.createElement('main');
  const query = new URLSearchParams(goal);
  const view = open(host, context as unknown as ViewContext, { database: 'demo', path: [], query });
  const buttonOf = (text: string) =>
    [...host.querySelectorAll('button')].find(({ textContent }) => textContent === text)!;
  const notice = () => host.querySelector('.plan-notice')?.textContent ?? '';
  return {
    host,
    view,
    buttonOf,
    notice,
    answer: host.querySelector<HTMLElement>('[aria-label=Answer]')!,
  };
}

// What the page says after the motion at 1 m was shown and its file downloaded, while the server
// now plans the motion at `height`.
async function download(height: number, outcome = PlanOutcome.EXACT): Promise<string> {
  saved.mockClear();
  const plan = vi
    .fn(() => Promise.resolve(answer({ ...motionAt(height), outcome })))
    .mockResolvedValueOnce(answer({ ...motionAt(1), outcome }));
  const { view, buttonOf, notice } = openPlan(plan);
  const csv = buttonOf('Download CSV');
  await vi.waitFor(() => {
    expect(csv.disabled).toBe(false);
  });
  csv.click();
  await vi.waitFor(() => {
    expect(plan).toHaveBeenCalledTimes(2);
    expect(notice()).toMatch(/Saved|changed/);
  });
  view.close();
  return notice();
}

test('the file of the shown motion is saved', async () => {
  expect(await download(1)).toBe('Saved plan.csv.');
  expect(saved).toHaveBeenCalledTimes(1);
});

test('a plan that has changed with the model is not saved', async () => {
  expect(await download(2)).toContain('The model has changed');
  expect(saved).not.toHaveBeenCalled();
});

test('a search that ended at its time limit is shown again with its file', async () => {
  expect(await download(2, PlanOutcome.DEADLINE)).toBe('Saved plan.csv.');
  expect(saved).toHaveBeenCalledTimes(1);
});

test('no answer stays beside the error of a newer question', async () => {
  const plan = vi
    .fn<() => Promise<unknown>>(() => Promise.reject(new Error('the goal is not on the floor')))
    .mockResolvedValueOnce(answer(motionAt(1)));
  const page = openPlan(plan);
  await vi.waitFor(() => {
    expect(page.answer.hidden).toBe(false);
  });
  page.buttonOf('Plan').form!.dispatchEvent(new Event('submit'));
  await vi.waitFor(() => {
    expect(page.notice()).toContain('the goal is not on the floor');
  });
  expect(page.answer.hidden).toBe(true);
  expect(page.buttonOf('Download CSV').disabled).toBe(true);
  page.view.close();
});

test('a robot that is larger than any request is not read', async () => {
  const plan = vi.fn();
  const { host, view, notice } = openPlan(plan, '');
  const arrayBuffer = vi.fn();
  const file = { name: 'robot.urdf', size: 2 ** 31, arrayBuffer };
  Object.defineProperty(host.querySelector('input[type=file]'), 'files', { value: [file] });
  host.querySelector('form')?.dispatchEvent(new Event('submit', { cancelable: true }));
  await vi.waitFor(() => {
    expect(notice()).toContain('robot.urdf: expected at most 1,024 MiB');
  });
  expect([arrayBuffer.mock.calls.length, plan.mock.calls.length]).toEqual([0, 0]);
  view.close();
});

test('a file does not replace a plan that was made meanwhile', async () => {
  let find: (found: unknown) => void = () => undefined;
  const finding = new Promise((resolve) => (find = resolve));
  const timed = { ...motionAt(1), outcome: PlanOutcome.DEADLINE };
  const newer = { ...motionAt(3), outcome: PlanOutcome.EXACT };
  const plan = vi
    .fn<() => Promise<unknown>>()
    .mockResolvedValueOnce(answer(timed))
    .mockReturnValueOnce(finding)
    .mockResolvedValueOnce(answer(newer));
  const page = openPlan(plan);
  await vi.waitFor(() => {
    expect(page.answer.textContent).toContain('best until the time limit');
  });
  page.buttonOf('Download CSV').click();
  page.buttonOf('Plan').form!.dispatchEvent(new Event('submit'));
  await vi.waitFor(() => {
    expect(page.answer.textContent).toContain('reaches the goal');
  });
  find(answer({ ...motionAt(2), outcome: PlanOutcome.DEADLINE }));
  await vi.waitFor(() => {
    expect(page.notice()).toContain('Saved');
  });
  expect(page.answer.textContent).toContain('reaches the goal');
  page.view.close();
});
