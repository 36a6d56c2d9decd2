import { afterEach, expect, test, vi } from 'vitest';
import { Header } from './header';
import { ThemeSwitch } from './theme';

afterEach(() => {
  localStorage.clear();
  vi.unstubAllGlobals();
});

test('the theme button offers the other theme, also after a change of the system', () => {
  const system = Object.assign(new EventTarget(), { matches: false });
  vi.stubGlobal('matchMedia', () => system);
  const header = new Header(new ThemeSwitch(), [], { changeDatabase: vi.fn(), leave: vi.fn() });
  header.draw({ session: null, view: '', database: '', databases: [] });
  const offered = () => header.node.querySelector('.tools button')?.textContent;
  expect(offered()).toBe('Dark');
  system.matches = true;
  system.dispatchEvent(new Event('change'));
  expect(offered()).toBe('Light');
  header.node.querySelector<HTMLButtonElement>('.tools button')?.click();
  expect(offered()).toBe('Dark');
  // The choice of the user is kept.
  system.matches = false;
  system.dispatchEvent(new Event('change'));
  expect(offered()).toBe('Dark');
});
