// Work of the main thread of a page, from a trace of Chromium.

const kCategories = ['disabled-by-default-devtools.timeline', 'devtools.timeline'];
const kPicture = 'picture of WebGL';

// Marks pictures in traces, for the pages that `page` opens later.
export function markPictures(page) {
  return page.addInitScript((text) => {
    const original = WebGL2RenderingContext.prototype.clear;
    WebGL2RenderingContext.prototype.clear = function (mask) {
      console.timeStamp(text);
      original.call(this, mask);
    };
  }, kPicture);
}

/**
 * Milliseconds of processor time of the main thread for each picture while `run` runs: scripts,
 * style, layout, paint and everything else until the next tick of the screen. Ticks without a new
 * picture do not count: this browser has no limit of its frame rate.
 */
export async function workOfPictures(page, run) {
  const browser = page.context().browser();
  await browser.startTracing(page, { categories: kCategories });
  await run();
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const isPicture = ({ name, args }) => name === 'TimeStamp' && args?.data?.message === kPicture;
  const first = traceEvents.find(isPicture);
  if (!first) throw new Error('expected pictures in the trace, got none');
  const own = traceEvents
    .filter(({ pid, tid }) => pid === first.pid && tid === first.tid)
    .sort((a, b) => a.ts - b.ts);
  const ticks = own.filter((event) => event.name === 'FireAnimationFrame' || isPicture(event));
  const pictures = [];
  let next = 0;
  let drawn = false;
  for (const { ts, dur, tdur = dur } of own.filter(
    ({ name, ph }) => name === 'RunTask' && ph === 'X',
  )) {
    const inside = [];
    while (next < ticks.length && ticks[next].ts <= ts + dur) inside.push(ticks[next++]);
    if (inside.length > 0) {
      drawn = inside.some(isPicture);
      if (drawn) pictures.push(0);
    }
    if (drawn) pictures[pictures.length - 1] += tdur / 1000;
  }
  return pictures;
}

// The value that a fraction of the values does not exceed.
export function percentile(values, fraction) {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(fraction * sorted.length))];
}
