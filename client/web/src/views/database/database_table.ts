import { button, element } from '../../dom/element';
import { count, percent } from '../../dom/format';
import type { DatabaseStatistics } from '../../api/messages';

// Table I of the paper: the properties of a database.
export function propertiesTable(statistics: DatabaseStatistics): HTMLElement {
  const rows: [string, string][] = [
    ['Frames', count(statistics.frameCount)],
    ['Clips', count(statistics.clipCount)],
    ['Stored clips', count(statistics.storedClipCount)],
    ['Layers', count(statistics.layerCount)],
    ['Nodes', count(statistics.nodeCount)],
    ['Nodes in the bottom layer', count(statistics.bottomNodeCount)],
    ['Dimensions of a state', count(statistics.dimensionCount)],
    ['Frame rate', `${statistics.frameRateHz} Hz`],
    ['Build time', `${statistics.buildSeconds.toFixed(2)} s`],
    ['Model version', count(statistics.modelVersion)],
    ['Clips added since the build', count(statistics.addedClipCount)],
    ['Drift', percent(statistics.driftFraction)],
  ];
  return element(
    'table',
    { class: 'properties' },
    element('caption', {}, 'Properties of the database'),
    element(
      'tbody',
      {},
      ...rows.map(([name, value]) =>
        element('tr', {}, element('th', { scope: 'row' }, name), numberCell(value)),
      ),
    ),
  );
}

// Clips and frames of each label.
export function labelTable(statistics: DatabaseStatistics): HTMLElement {
  const rows = statistics.labels.map(({ label, clipCount, frameCount }) =>
    element(
      'tr',
      {},
      element('th', { scope: 'row' }, label === '' ? '(no label)' : label),
      numberCell(count(clipCount)),
      numberCell(count(frameCount)),
    ),
  );
  return tableOf('Labels', ['Label', 'Clips', 'Frames'], rows);
}

// Nodes of each layer; each row opens its layer.
export function layerTable(
  nodesPerLayer: readonly number[],
  current: number,
  open: (layer: number) => void,
): HTMLElement {
  const rows = nodesPerLayer.map((nodes, i) => {
    const layer = i + 1;
    const opener = button(
      `Layer ${layer}`,
      () => {
        open(layer);
      },
      {
        'aria-pressed': layer === current ? 'true' : 'false',
        'data-key': `layer ${layer}`,
      },
    );
    return element('tr', {}, element('td', {}, opener), numberCell(count(nodes)));
  });
  return tableOf('Nodes of each layer', ['Layer', 'Nodes'], rows);
}

function tableOf(caption: string, heads: string[], rows: HTMLElement[]): HTMLElement {
  const header = heads.map((head, i) =>
    element('th', { scope: 'col', class: i > 0 ? 'number' : null }, head),
  );
  const table = element(
    'table',
    {},
    element('caption', {}, caption),
    element('thead', {}, element('tr', {}, ...header)),
    element('tbody', {}, ...rows),
  );
  return element(
    'div',
    { class: 'table-scroll', tabindex: 0, role: 'region', 'aria-label': caption },
    table,
  );
}

function numberCell(text: string): HTMLElement {
  return element('td', { class: 'number' }, text);
}
