import { beforeEach, expect, test, vi } from 'vitest';
import { FilterBox } from './filter_box';

const kSent = 'label = = walk';
const failure = new Error("filter: byte 9: expected a value, got '='");

let apply = vi.fn();
let box: FilterBox;
let input: HTMLInputElement;

beforeEach(() => {
  apply = vi.fn();
  box = new FilterBox('', '', { apply });
  document.body.replaceChildren(box.node);
  input = box.node.querySelector('input')!;
});

function submit(text: string) {
  input.value = text;
  box.node.dispatchEvent(new Event('submit', { cancelable: true }));
}

const selected = () => input.value.slice(input.selectionStart ?? 0, input.selectionEnd ?? 0);
const marked = () => box.node.querySelector('.filter-error mark')?.textContent;

test('an applied filter with an error is selected from there', () => {
  submit(` ${kSent} `);
  expect(apply.mock.calls).toEqual([[kSent, '']]);
  box.showError(failure, kSent);
  expect([selected(), marked()]).toEqual(['= walk', '= walk']);
});

test('a list that fails again leaves the selection', () => {
  submit(kSent);
  box.showError(failure, kSent);
  input.setSelectionRange(3, 3);
  box.showError(failure, kSent);
  expect([input.selectionStart, input.selectionEnd]).toEqual([3, 3]);
  // An answer without an error is also one.
  submit(kSent);
  box.clearError();
  input.setSelectionRange(3, 3);
  box.showError(failure, kSent);
  expect([input.selectionStart, input.selectionEnd]).toEqual([3, 3]);
});

test('text that was typed since is not selected; the mark is that of the applied text', () => {
  submit(kSent);
  input.value = 'label = wal';
  input.setSelectionRange(11, 11);
  box.showError(failure, kSent);
  expect([selected(), marked()]).toEqual(['', '= walk']);
});
