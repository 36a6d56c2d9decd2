// Bars: figures that must not exceed, or fall below, a limit.
import assert from 'node:assert/strict';
import { isBusy } from './busy.mjs';

/**
 * Prints a figure, its bar and whether it is met, in one line. Fails if it is missed; a figure of
 * time counts only on a machine that has nothing else to do. `limit`: {most} or {least}.
 */
export function checkBar(t, name, value, unit, { most, least }, isTime = true) {
  const met = most !== undefined ? value <= most : value >= least;
  const bar = most !== undefined ? `at most ${most}` : `at least ${least}`;
  const counts = !isTime || !isBusy();
  const digits = Number.isInteger(value) ? 0 : value < 100 ? 2 : 0;
  const line = `BAR ${name}: ${value.toFixed(digits)} ${unit} (${bar} ${unit}): ${met ? 'met' : 'MISSED'}`;
  t.diagnostic(counts ? line : `${line}; does not count: busy machine`);
  if (counts) assert.ok(met, line);
}
