// What the list of clips shows, as in its URL.

export interface ClipListState {
  filter: string;
  // Words of the full-text search; empty: the list in order.
  search: string;
  orderBy: string;
  // Tokens of the pages up to the present one; the first page has none. Empty: not known, because
  // the URL has only the token of its page.
  pages: string[];
}

export const kFacetFields = ['label', 'subject', 'tags', 'track', 'format', 'source'] as const;
export const kPageSize = 50;

export function stateOf(query: URLSearchParams): ClipListState {
  return {
    filter: query.get('filter') ?? '',
    search: query.get('search') ?? '',
    orderBy: query.get('order') ?? 'name',
    pages: pagesOf(query),
  };
}

// Values of the URL; default values are left out.
export function queryOf(state: ClipListState): Record<string, string | null> {
  return {
    filter: state.filter,
    search: state.search,
    order: state.orderBy === 'name' ? null : state.orderBy,
    page: state.pages.length === 0 ? null : String(state.pages.length + 1),
    after: state.pages.at(-1) ?? null,
  };
}

// The tokens of the page before; those of the first page if its token is not known.
export function previousPages(pages: readonly string[]): string[] {
  const before = pages.slice(0, -1);
  return before.at(-1) === '' ? [] : before;
}

function pagesOf(query: URLSearchParams): string[] {
  const after = query.get('after') ?? '';
  const page = Number(query.get('page'));
  if (after === '' || !Number.isInteger(page) || page < 2 || page > 1e6) return [];
  return [...Array<string>(page - 2).fill(''), after];
}

// The order after a click on the heading of a field: ascending, then descending.
export function nextOrder(orderBy: string, field: string): string {
  return orderBy === field ? `${field} desc` : field;
}

export function sortDirection(orderBy: string, field: string): 'ascending' | 'descending' | null {
  if (orderBy === field) return 'ascending';
  return orderBy === `${field} desc` ? 'descending' : null;
}
