import { expect, test } from 'vitest';
import { PlaybackClock } from './playback_clock';

test('every frame has a time that gives the frame back', () => {
  for (const rate of [24, 29.97, 60, 119.88]) {
    const clock = new PlaybackClock(1000 / rate, rate);
    for (let frame = 0; frame < 1000; ++frame) {
      clock.seek(frame / rate);
      expect(clock.frame).toBe(frame);
    }
  }
});

test('steps by frames and stops', () => {
  const clock = new PlaybackClock(10, 60);
  clock.play();
  clock.seek(1);
  clock.step(1);
  expect(clock.playing).toBe(false);
  expect(clock.frame).toBe(61);
  clock.step(-100);
  expect(clock.frame).toBe(0);
});

test('loops, with speed and range', () => {
  const clock = new PlaybackClock(10, 60);
  clock.speed = 2;
  clock.range = { begin: 2, end: 4 };
  clock.seek(2);
  clock.play();
  clock.advance(0.5);
  expect(clock.time).toBeCloseTo(3);
  clock.advance(0.75);
  expect(clock.time).toBeCloseTo(2.5);
  expect(clock.playing).toBe(true);
});

test('without loop it stops at the last frame, and begins anew when played again', () => {
  const clock = new PlaybackClock(1, 60);
  clock.loop = false;
  clock.play();
  clock.advance(5);
  expect(clock.playing).toBe(false);
  expect(clock.frame).toBe(59);
  clock.play();
  expect(clock.time).toBe(0);
});

test('stays inside the clip', () => {
  const clock = new PlaybackClock(1, 60);
  for (const seconds of [-3, NaN, 99, Infinity]) {
    clock.seek(seconds);
    expect(clock.frame).toBeGreaterThanOrEqual(0);
    expect(clock.frame).toBeLessThan(60);
  }
});

test('an address with a rounded time opens the frame that it was written at', () => {
  for (const rate of [24, 30, 60, 120, 250, 1000]) {
    for (let frame = 0; frame < rate; ++frame) {
      const clock = new PlaybackClock(0, 60);
      clock.resize(1, rate, Number((frame / rate).toFixed(4)));
      expect(clock.frame).toBe(frame);
    }
  }
});
