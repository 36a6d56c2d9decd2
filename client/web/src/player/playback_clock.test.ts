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

// Pictures of 60 and 120 Hz screens, of clips whose frames are longer than these at some speeds.
const steps = [1 / 60, 1 / 120].flatMap((step) =>
  [1, 0.5, 0.1].flatMap((speed) => [30, 60].map((rate) => ({ step, speed, rate }))),
);

// The frames that are shown in the pictures until the clock stops, or at most in `seconds`.
function playFor(clock: PlaybackClock, step: number, seconds: number): number[] {
  const frames: number[] = [];
  for (let at = 0; at < seconds && clock.playing; at += step) {
    frames.push(clock.frame);
    clock.advance(step);
    expect(clock.time).toBeLessThanOrEqual(clock.duration - 1 / clock.frameRate);
  }
  return frames;
}

test.each(steps)('ends with steps of $step s at $speed x, $rate Hz', ({ step, speed, rate }) => {
  for (const range of [null, { begin: 0.5, end: 1 }]) {
    const clock = new PlaybackClock(1, rate);
    clock.loop = false;
    clock.speed = speed;
    clock.range = range;
    clock.seek(range?.begin ?? 0);
    clock.play();
    const length = (1 - (range?.begin ?? 0)) / speed;
    const pictures = playFor(clock, step, 2 * length + 1).length;
    expect(clock.playing).toBe(false);
    expect(clock.frame).toBe(rate - 1);
    expect(clock.time).toBeCloseTo(1 - 1 / rate, 9);
    expect(Math.abs(pictures * step - length)).toBeLessThan(1.5 * step);
  }
});

test.each(steps)('loops with steps of $step s at $speed x, $rate Hz', ({ step, speed, rate }) => {
  for (const begin of [0, 0.5]) {
    const clock = new PlaybackClock(1, rate);
    clock.speed = speed;
    clock.range = begin > 0 ? { begin, end: 1 } : null;
    clock.seek(begin);
    clock.play();
    const frames = playFor(clock, step, (3.5 * (1 - begin)) / speed);
    expect(clock.playing).toBe(true);
    const starts = frames.flatMap((frame, i) => (i > 0 && frame < frames[i - 1]! ? [i] : []));
    expect(starts.length).toBe(3);
    // The last frame is shown as long as each other, to a picture.
    const last = frames.slice(0, starts[0]).filter((frame) => frame === rate - 1).length;
    expect(Math.abs(last - 1 / (rate * step * speed))).toBeLessThanOrEqual(1);
  }
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
