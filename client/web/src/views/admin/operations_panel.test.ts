import { expect, test, vi } from 'vitest';
import { OperationState } from '../../api/messages';
import type { RoleName } from '../../api/session';
import { Disposer } from '../../dom/disposer';
import type { ViewContext } from '../../shell/view';
import { OperationsPanel } from './operations_panel';

test('the roles ingester and admin may cancel an operation that runs', async () => {
  const operation = {
    name: 'operations/1',
    database: 'databases/demo',
    state: OperationState.RUNNING,
    stage: 'splitting nodes',
    progress: 0.5,
    result: { case: undefined },
  };
  const done = { ...operation, name: 'operations/2', state: OperationState.SUCCEEDED };
  const operations = {
    listOperations: () => Promise.resolve({ operations: [operation, done] }),
    cancelOperation: vi.fn(() => Promise.resolve({})),
  };
  const buttonsOf = async (role: RoleName) => {
    const disposer = new Disposer();
    const context = { api: { operations }, session: { role } } as unknown as ViewContext;
    const panel = new OperationsPanel(context, disposer);
    await vi.waitFor(() => {
      expect(panel.node.querySelectorAll('tbody tr').length).toBe(2);
    });
    disposer.dispose();
    return panel.node.querySelectorAll('button');
  };
  expect((await buttonsOf('reader')).length).toBe(0);
  expect((await buttonsOf('admin')).length).toBe(1);
  const [cancel, ...others] = await buttonsOf('ingester');
  expect(others).toEqual([]);
  cancel?.click();
  expect(operations.cancelOperation).toHaveBeenCalledWith(
    { name: 'operations/1' },
    expect.anything(),
  );
});
