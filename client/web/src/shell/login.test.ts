import { expect, test, vi } from 'vitest';
import { openLogin } from './login';

test('the form shows why the session has ended', () => {
  const host = document.createElement('main');
  openLogin(host, 'tokens/ab was revoked', vi.fn());
  const notice = host.querySelector('.notice.error:not([hidden])');
  expect(notice?.textContent).toBe('Log in again: tokens/ab was revoked.');
  openLogin(host, '', vi.fn());
  expect(host.querySelector('.notice:not([hidden])')).toBeNull();
});
