// What the list of clips shows, as in its URL.

export interface ClipListState {
  filter: string;
  // Words of the full-text search; empty: the list in order.
  search: string;
  orderBy: string;
  // Tokens of the pages up to the present one; the first page has none.
  pages: string[];
}

export const kFacetFields = ['label', 'subject', 'tags', 'track', 'format', 'source'] as const;
export const kPageSize = 50;

export function stateOf(query: URLSearchParams): ClipListState {
  return {
    filter: query.get('filter') ?? '',
    search: query.get('search') ?? '',
    orderBy: query.get('order') ?? 'name',
    pages: [],
  };
}

// Values of the URL; default values are left out.
export function queryOf(state: ClipListState): Record<string, string | null> {
  return {
    filter: state.filter,
    search: state.search,
    order: state.orderBy === 'name' ? null : state.orderBy,
  };
}

// The order after a click on the heading of a field: ascending, then descending.
export function nextOrder(orderBy: string, field: string): string {
  return orderBy === field ? `${field} desc` : field;
}

export function sortDirection(orderBy: string, field: string): 'ascending' | 'descending' | null {
  if (orderBy === field) return 'ascending';
  return orderBy === `${field} desc` ? 'descending' : null;
}
