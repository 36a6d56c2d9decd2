import { element, type Child } from './element';

export interface Column {
  title: string;
  number?: boolean;
}

// A table; each row has as many cells as there are columns. It scrolls sideways on narrow screens.
export function tableOf(
  caption: string,
  columns: readonly Column[],
  rows: readonly (readonly Child[])[],
): HTMLElement {
  const classOf = (column: Column | undefined) => (column?.number === true ? 'number' : null);
  const head = columns.map((column) =>
    element('th', { scope: 'col', class: classOf(column) }, column.title),
  );
  const body = rows.map((cells) =>
    element(
      'tr',
      {},
      ...cells.map((cell, index) => element('td', { class: classOf(columns[index]) }, cell)),
    ),
  );
  return element(
    'div',
    {
      class: 'table-scroll',
      role: 'group',
      'aria-label': caption,
      tabindex: 0,
      'data-key': caption,
    },
    element(
      'table',
      {},
      element('thead', {}, element('tr', {}, ...head)),
      element('tbody', {}, ...body),
    ),
  );
}
