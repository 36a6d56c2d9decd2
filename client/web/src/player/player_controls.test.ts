import { expect, test } from 'vitest';
import { element } from '../dom/element';
import { PlaybackClock } from './playback_clock';
import { PlayerControls, speedOf } from './player_controls';

test('only the offered speeds are accepted', () => {
  expect(speedOf('0.25')).toBe(0.25);
  for (const text of [null, '', '0', '-1', '1e9', '3', '0.250', 'Infinity'])
    expect(speedOf(text)).toBe(1);
});

test('Space plays, but not on a control that it operates', () => {
  const clock = new PlaybackClock(1, 60);
  const player = new PlayerControls(clock);
  const pressOn = (target: HTMLElement, outer: HTMLElement = target) => {
    document.body.replaceChildren(outer);
    const event = new KeyboardEvent('keydown', { key: ' ', bubbles: true, cancelable: true });
    target.dispatchEvent(event);
    return player.press(event) && event.defaultPrevented;
  };
  const inButton = element('span', {});
  expect(pressOn(element('input', { type: 'checkbox' }))).toBe(false);
  expect(pressOn(inButton, element('button', {}, inButton))).toBe(false);
  expect(pressOn(element('summary', {}))).toBe(false);
  expect(pressOn(element('input', {}))).toBe(false);
  expect(clock.playing).toBe(false);
  expect(pressOn(element('div', {}))).toBe(true);
  expect(clock.playing).toBe(true);
  expect(pressOn(element('input', { type: 'range' }))).toBe(true);
  expect(clock.playing).toBe(false);
});

test('the keys of single letters can be switched off, and stay off', () => {
  const open = () => {
    const clock = new PlaybackClock(1, 60);
    const controls = new PlayerControls(clock);
    document.body.replaceChildren(controls.node);
    const keys = [...controls.node.querySelectorAll('label')].find((label) =>
      label.textContent.startsWith('Keys'),
    )!.control as HTMLInputElement;
    const press = (key: string) => controls.press(new KeyboardEvent('keydown', { key }));
    return { clock, keys, press };
  };
  const first = open();
  expect(first.press('.')).toBe(true);
  expect(first.clock.frame).toBe(1);
  first.keys.click();
  expect(first.press('.')).toBe(false);
  expect(first.press('End')).toBe(true);
  expect(open().press(',')).toBe(false);
  open().keys.click();
  expect(open().press(',')).toBe(true);
});
