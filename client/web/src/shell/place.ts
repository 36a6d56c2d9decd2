// A place in the page, as the part of the URL after `#`: #/VIEW/DATABASE/PATH...?QUERY

export interface Place {
  view: string;
  // Id of the database; empty for a view of the whole server.
  database?: string;
  path?: readonly string[];
  query?: URLSearchParams | Record<string, string>;
}

export interface ParsedPlace {
  view: string;
  database: string;
  path: string[];
  query: URLSearchParams;
}

// The URL fragment of a place, with `#`.
export function hrefOf(place: Place): string {
  const parts = [place.view];
  if (place.database !== undefined && place.database !== '')
    parts.push(place.database, ...(place.path ?? []));
  const query = new URLSearchParams(place.query ?? {}).toString();
  return `#/${parts.map(encodeURIComponent).join('/')}${query === '' ? '' : `?${query}`}`;
}

// The place of a URL fragment. A part that is not valid percent-encoding is taken as it is.
export function parsePlace(fragment: string): ParsedPlace {
  const text = fragment.replace(/^#?\/?/, '');
  const mark = text.indexOf('?');
  const [view = '', database = '', ...path] = (mark < 0 ? text : text.slice(0, mark))
    .split('/')
    .map(decode);
  return {
    view,
    database,
    path: path.filter((part) => part !== ''),
    query: new URLSearchParams(mark < 0 ? '' : text.slice(mark + 1)),
  };
}

function decode(part: string): string {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
