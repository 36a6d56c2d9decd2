import { expect, test, vi } from 'vitest';
import { Disposer } from '../../dom/disposer';
import type { ViewContext } from '../../shell/view';
import { TokensPanel } from './tokens_panel';

test('a token that is asked for twice is created once, and its secret is shown', async () => {
  const answers: ((answer: { secret: string }) => void)[] = [];
  const createToken = vi.fn(
    () =>
      new Promise<{ secret: string }>((resolve, reject) => {
        answers.push(resolve);
        if (answers.length === 2) reject(new Error('no'));
      }),
  );
  const listTokens = () => Promise.resolve({ tokens: [], nextPageToken: '' });
  const context = { api: { access: { createToken, listTokens } } } as unknown as ViewContext;
  const panel = new TokensPanel(context, new Disposer());
  const form = panel.node.querySelector('form')!;
  const submit = form.querySelector<HTMLButtonElement>('[type=submit]')!;
  const press = () => form.dispatchEvent(new Event('submit', { cancelable: true }));
  const enabled = () =>
    vi.waitFor(() => {
      expect(submit.disabled).toBe(false);
    });
  press();
  press();
  expect([createToken.mock.calls.length, submit.disabled]).toEqual([1, true]);
  answers[0]!({ secret: 'mdb_1' });
  await enabled();
  expect(panel.node.querySelector('.secret')?.textContent).toBe('mdb_1');
  // After an error, too.
  press();
  await enabled();
  expect(panel.node.textContent).toContain('no');
  press();
  expect(createToken).toHaveBeenCalledTimes(3);
});
