import { afterEach, expect, test, vi } from 'vitest';
import { element } from './element';
import { focusHeading } from './focus';

afterEach(() => {
  document.body.replaceChildren();
});

function openPage() {
  const link = element('a', { href: '#/clips/demo' });
  const menu = element('select');
  const view = element('main', {}, element('h1', {}, 'Clips of demo'));
  document.body.append(link, menu, view);
  return { link, menu, view, heading: view.querySelector('h1') };
}

test('the focus goes from a link, or from nowhere, to the heading of the new view', () => {
  const { link, view, heading } = openPage();
  const announce = vi.fn();
  for (const leave of [
    () => {
      link.focus();
    },
    () => {
      link.blur();
    },
  ]) {
    leave();
    focusHeading(view, announce);
    expect(document.activeElement).toBe(heading);
    heading?.blur();
  }
  // Not with the tab key.
  expect(heading?.tabIndex).toBe(-1);
  expect(announce).not.toHaveBeenCalled();
});

test('a menu keeps the focus, and the heading is announced', () => {
  const { menu, view } = openPage();
  const announce = vi.fn();
  menu.focus();
  focusHeading(view, announce);
  expect(document.activeElement).toBe(menu);
  expect(announce).toHaveBeenCalledWith('Clips of demo');
});
