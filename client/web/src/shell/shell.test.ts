// The frame around the views, with views of the test.
import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import { Shell } from './shell';
import type { OpenView } from './view';

const views = {
  load: vi.fn<() => Promise<{ open: OpenView }>>(),
  other: vi.fn<() => Promise<{ open: OpenView }>>(),
};
const kRoute = { needsDatabase: false, role: 'admin' } as const;
const kRoutes = [
  { ...kRoute, view: 'some', title: 'Some view', load: views.load },
  { ...kRoute, view: 'other', title: 'Other view', load: views.other },
];
const kAdmin = { authenticationRequired: true, principal: 'tokens/1', role: 'admin' };
const server = { up: true, session: kAdmin };

// A server with a session and without databases.
function answer(path: string | URL): Promise<Response> {
  if (!server.up) return Promise.reject(new TypeError('refused'));
  if (path === '/session') return Promise.resolve(Response.json(server.session));
  const headers = { 'content-type': 'application/proto' };
  return Promise.resolve(new Response(new Uint8Array(), { headers }));
}

// What a new load of the page ends.
let leave = new AbortController();
function leavePage() {
  leave.abort();
  leave = new AbortController();
  vi.clearAllTimers();
  document.body.replaceChildren();
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('matchMedia', () => new EventTarget());
  vi.stubGlobal('fetch', answer);
  const listen = window.addEventListener.bind(window);
  vi.stubGlobal('addEventListener', (...[type, listener]: Parameters<typeof listen>) => {
    listen(type, listener, { signal: leave.signal });
  });
  sessionStorage.clear();
  Object.assign(server, { up: true, session: kAdmin });
  for (const load of [views.load, views.other]) {
    load.mockReset();
    load.mockImplementation(() => Promise.resolve({ open: opens() }));
  }
});
afterEach(() => {
  leavePage();
  vi.useRealTimers();
  vi.unstubAllGlobals();
  history.replaceState(null, '', '#/');
});

const closed = vi.fn();
const opens = (): OpenView =>
  vi.fn((host: HTMLElement) => {
    host.append('the view');
    return { close: closed };
  });

// A page at a place, as if the browser had loaded it now.
async function loadPage(place: string) {
  leavePage();
  history.replaceState(null, '', `#/${place}`);
  const root = document.createElement('div');
  document.body.replaceChildren(root);
  const reload = vi.fn();
  await new Shell(root, kRoutes, reload).start();
  const main = root.querySelector('main')!;
  const error = () => main.querySelector('.notice.error:not([hidden])')?.textContent ?? '';
  const lost = () => root.textContent.includes('Connection lost.');
  return { root, main, reload, error, lost };
}

async function go(place: string) {
  history.replaceState(null, '', `#/${place}`);
  dispatchEvent(new HashChangeEvent('hashchange'));
  await vi.advanceTimersByTimeAsync(10);
}

const blocked = () => Promise.reject(new TypeError('Failed to fetch dynamically imported module'));

test('scripts that stay blocked load the page again once, and the error stays', async () => {
  views.load.mockImplementation(blocked);
  const first = await loadPage('some');
  await vi.advanceTimersByTimeAsync(10_000);
  expect(first.reload).toHaveBeenCalledTimes(1);
  const second = await loadPage('some');
  await vi.advanceTimersByTimeAsync(30_000);
  expect(second.reload).not.toHaveBeenCalled();
  expect([second.lost(), second.error()]).toEqual([false, expect.stringContaining('could not be')]);
  second.main.querySelector<HTMLButtonElement>('.notice.error button')?.click();
  expect(second.reload).toHaveBeenCalledTimes(1);
  // Another view works; then one new load is possible again.
  await go('other');
  expect([second.error(), second.main.textContent]).toEqual(['', 'the view']);
  await go('some');
  await vi.advanceTimersByTimeAsync(10_000);
  expect(second.reload).toHaveBeenCalledTimes(2);
});

test('scripts that fail because the server is gone are loaded when it is back', async () => {
  const page = await loadPage('other');
  server.up = false;
  views.load.mockImplementation(blocked);
  await go('some');
  await vi.advanceTimersByTimeAsync(5000);
  expect([page.lost(), page.reload.mock.calls.length]).toEqual([true, 0]);
  expect(page.error()).toContain('could not be loaded');
  server.up = true;
  await vi.advanceTimersByTimeAsync(5000);
  expect(page.reload).toHaveBeenCalledTimes(1);
});

test('an error of a view that opens is shown, and is not a lost connection', async () => {
  const open = () => {
    throw new TypeError('no property');
  };
  views.load.mockImplementation(() => Promise.resolve({ open }));
  const page = await loadPage('some');
  await vi.advanceTimersByTimeAsync(10_000);
  expect([page.lost(), page.reload.mock.calls.length]).toEqual([false, 0]);
  expect(page.error()).toContain('no property');
});

test('another login in the browser opens the page again with its role', async () => {
  const page = await loadPage('some');
  expect(page.main.textContent).toBe('the view');
  closed.mockClear();
  server.session = { ...kAdmin, principal: 'tokens/2', role: 'reader' };
  await vi.advanceTimersByTimeAsync(3100);
  expect(closed).toHaveBeenCalledTimes(1);
  expect(page.error()).toContain('This view needs the role admin.');
  expect(page.root.querySelector('header')?.textContent).toContain('tokens/2');
  expect(page.root.querySelectorAll('nav a').length).toBe(0);
  server.session = { ...kAdmin, principal: 'tokens/3' };
  await vi.advanceTimersByTimeAsync(3100);
  expect([page.error(), page.main.textContent]).toEqual(['', 'the view']);
  expect(page.root.querySelectorAll('nav a').length).toBe(2);
});

test('the title of the page is that of what it shows', async () => {
  await loadPage('some');
  expect(document.title).toBe('Some view - motiondb');
  await go('none');
  expect(document.title).toBe('Unknown view - motiondb');
  views.other.mockImplementation(blocked);
  await go('other');
  expect(document.title).toBe('Other view - motiondb');
  await go('some');
  expect(document.title).toBe('Some view - motiondb');
  server.session = { ...kAdmin, role: '' };
  await vi.advanceTimersByTimeAsync(3100);
  expect(document.title).toBe('Log in - motiondb');
  server.session = { ...kAdmin, role: 'reader' };
  await loadPage('some');
  expect(document.title).toBe('Some view - motiondb');
});
