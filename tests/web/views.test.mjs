// Every view with its lists, ribbons and charts, with and without WebGL, in both themes.
import { test } from 'node:test';
import { checkAccessibility, disableWebGL, newPage } from './support/browser.mjs';
import { setup } from './support/setup.mjs';

// A place, and what it shows.
const views = [
  ['clips/demo', ['main tbody tr', '.facet']],
  ['clip/demo/01_01', ['.segment-body', '.chart canvas']],
  ['database/demo?layer=4', ['table.properties tr', '.axis-ends svg']],
  [
    'query/demo?clip=01_01&to=2&at=1&layers=3&without=0',
    ['.ribbon rect:visible', 'figure.profile'],
  ],
  ['plan/demo?goal=2,1,0', ['section[aria-label="Planned motions"] tbody tr', '.floor .place']],
  ['live/demo', ['.hint:has-text("No stream runs")']],
  ['admin', ['.chart canvas', 'section[aria-label="Operations"] tbody tr']],
];

// The tests of each view check the light theme with WebGL.
for (const [colorScheme, webgl] of [
  ['dark', true],
  ['light', false],
]) {
  const name = `${webgl ? 'with' : 'without'} WebGL in the ${colorScheme} theme`;
  test(`every view has its content ${name}, and axe reports nothing`, async (t) => {
    const page = await newPage(t, { colorScheme });
    if (!webgl) await disableWebGL(page);
    for (const [place, contents] of views) {
      await t.test(place, async () => {
        await page.goto(`${setup.open}/#/${place}`);
        for (const content of contents) await page.locator(content).first().waitFor();
        await checkAccessibility(page);
      });
    }
  });
}
