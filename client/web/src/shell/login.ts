import { logIn } from '../api/session';
import { element, labelled } from '../dom/element';
import { Notice } from '../dom/notice';

// Shows the login form; calls `done` after a successful login. `reason`: why the session has ended;
// may be empty.
export function openLogin(host: HTMLElement, reason: string, done: () => void): void {
  const token = element('input', {
    type: 'password',
    name: 'token',
    autocomplete: 'current-password',
    required: true,
    spellcheck: 'false',
  });
  const submit = element('button', { type: 'submit', class: 'primary' }, 'Log in');
  const notice = new Notice();
  const form = element(
    'form',
    { class: 'login panel', 'aria-labelledby': 'login-title' },
    element('h1', { id: 'login-title' }, 'Log in'),
    element(
      'p',
      {},
      'The server needs a token. An administrator creates it with ',
      element('code', {}, 'motiondb token create'),
      '.',
    ),
    labelled('Token', token),
    submit,
    notice.node,
  );
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    submit.disabled = true;
    notice.clear();
    logIn(token.value.trim())
      .then(
        () => {
          token.value = '';
          done();
        },
        (error: unknown) => {
          notice.error(error);
          token.focus();
          token.select();
        },
      )
      .finally(() => {
        submit.disabled = false;
      });
  });
  host.replaceChildren(form);
  if (reason !== '') notice.error(new Error(`Log in again: ${reason}.`));
  token.focus();
}
