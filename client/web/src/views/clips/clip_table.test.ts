import { create } from '@bufbuild/protobuf';
import { expect, test, vi } from 'vitest';
import { ClipSchema } from '../../api/messages';
import { element } from '../../dom/element';
import { ClipTable } from './clip_table';
import type { Thumbnails } from './thumbnail';

vi.stubGlobal('CSS', { escape: (text: string) => text }); // jsdom has none

const clips = ['a', 'b'].map((id) => create(ClipSchema, { name: `databases/demo/clips/${id}` }));

function tableOf() {
  const remove = vi.fn(() => Promise.resolve(true));
  const thumbnails = { clear: vi.fn(), create: () => element('canvas') };
  const table = new ClipTable({
    database: 'demo',
    thumbnails: thumbnails as unknown as Thumbnails,
    remove,
    order: vi.fn(),
  });
  document.body.replaceChildren(table.node);
  table.draw(clips, '');
  const buttonOf = (id: string) =>
    table.node.querySelector<HTMLButtonElement>(`[data-key="delete ${id}"]`)!;
  const click = (id: string) => {
    buttonOf(id).focus();
    buttonOf(id).click();
  };
  return { table, remove, buttonOf, click };
}

test('a redraw of the table keeps the question of a clip', () => {
  const { table, remove, buttonOf, click } = tableOf();
  click('b');
  expect(buttonOf('b').textContent).toBe('Really delete');
  table.draw(clips, '');
  expect([buttonOf('a'), buttonOf('b')].map((node) => node.textContent)).toEqual([
    'Delete',
    'Really delete',
  ]);
  expect(buttonOf('b').getAttribute('aria-label')).toBe('Really delete b');
  expect(document.activeElement).toBe(buttonOf('b'));
  click('b');
  expect(remove.mock.calls).toEqual([[clips[1]]]);
  expect([buttonOf('b').disabled, buttonOf('b').textContent]).toEqual([true, 'Delete']);
});

test('a question ends when its button loses the focus, or its clip leaves the table', () => {
  const { table, remove, buttonOf, click } = tableOf();
  click('a');
  buttonOf('b').focus();
  table.draw(clips, '');
  expect(buttonOf('a').textContent).toBe('Delete');
  click('a');
  table.draw([clips[1]!], '');
  table.draw(clips, '');
  expect(buttonOf('a').textContent).toBe('Delete');
  click('a');
  expect(remove).not.toHaveBeenCalled();
});

test('a deletion that fails can be repeated', async () => {
  const { remove, buttonOf, click } = tableOf();
  remove.mockResolvedValueOnce(false);
  click('b');
  click('b');
  await vi.waitFor(() => {
    expect(buttonOf('b').disabled).toBe(false);
  });
  click('b');
  click('b');
  expect(remove).toHaveBeenCalledTimes(2);
  await remove.mock.results[1]?.value;
  expect(buttonOf('b').disabled).toBe(true);
});
