import { afterEach, beforeEach, expect, test, vi } from 'vitest';
import type { Api } from '../../api/api';
import type { ThemeSwitch } from '../../shell/theme';
import { EmphasisLayer } from './map_picture';
import { loadMap } from './state_map';
import { MapPanel, type MapContent } from './map_panel';
import { stateMapOf, stubDrawing } from './test_map';

const calls: string[] = [];

// A flat canvas that counts what is drawn, and no WebGL.
beforeEach(() => {
  stubDrawing();
  calls.length = 0;
  const context = new Proxy(
    {},
    { get: (_, name) => () => calls.push(String(name)), set: () => true },
  );
  vi.spyOn(HTMLCanvasElement.prototype, 'getContext').mockImplementation(((kind: string) =>
    kind === '2d' ? context : null) as never);
});
afterEach(() => {
  vi.restoreAllMocks();
});

const circlesOf = (node: Element) =>
  [...node.querySelectorAll('circle')].map((circle) => [
    Number(circle.getAttribute('cx')),
    Number(circle.getAttribute('cy')),
    circle.style.fill,
  ]);
const pathOf = (node: Element) => node.querySelector('.map-emphasis path')?.getAttribute('d');

test('nodes and steps of the path are where the map shows them', () => {
  const layer = new EmphasisLayer();
  const host = document.createElement('div');
  host.append(layer.node);
  // Node 2 is outside the view.
  const placeOf = (node: number) => (node === 2 ? undefined : { x: 10 * node, y: node });
  const nodes = new Map([1, 2, 3].map((node) => [node, '--path']));
  layer.draw({ nodes: nodes.set(4, '--next'), path: [3, 1, 2, 3, 4] }, placeOf);
  expect(circlesOf(host)).toEqual([
    [10, 1, 'var(--path)'],
    [30, 3, 'var(--path)'],
    [40, 4, 'var(--next)'],
  ]);
  expect(pathOf(host)).toBe('M30 3L10 1M30 3L40 4');
  layer.draw({ nodes: new Map(), path: [] }, placeOf);
  expect([circlesOf(host), pathOf(host)]).toEqual([[], '']);
});

test('another node is emphasized without drawing the map again', async () => {
  const api = { views: { readStateMap: () => stateMapOf(1, [4, 5, 6]) } } as unknown as Api;
  const request = { database: 'demo', layer: 2, clip: '', maxPoints: 0 };
  const map = await loadMap(api, request, new AbortController().signal);
  const theme = { name: 'light', onChange: () => () => undefined, color: () => '#000000' };
  const panel = new MapPanel({
    theme: theme as unknown as ThemeSwitch,
    label: 'Map',
    onPoint: () => undefined,
    onChoose: () => undefined,
  });
  panel.open(null);
  const content: MapContent = {
    map,
    axes: '12',
    colorBy: 'label',
    hiddenLabels: [],
    leastProbability: 0,
    size: 1,
  };
  const show = (node: number) => {
    panel.show({ ...content }, { nodes: new Map([[node, '--path']]), path: [] });
    return circlesOf(panel.node);
  };
  const first = show(0);
  const drawn = calls.length;
  expect(calls.filter((name) => name === 'fillRect')).toHaveLength(3);
  const second = show(2);
  expect(calls).toHaveLength(drawn);
  expect([first, second].map((circles) => circles.length)).toEqual([1, 1]);
  expect(second[0]).not.toEqual(first[0]);
  // The camera moves: the map is drawn again, and the circle is at its new place.
  panel.node.querySelector('canvas')?.dispatchEvent(new KeyboardEvent('keydown', { key: '+' }));
  expect(calls.length).toBeGreaterThan(drawn);
  expect(circlesOf(panel.node)[0]).not.toEqual(second[0]);
  panel.close();
});
