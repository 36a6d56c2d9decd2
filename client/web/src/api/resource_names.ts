// Resource names of motiondb.v1.

export function databaseName(id: string): string {
  return `databases/${id}`;
}

export function clipName(databaseId: string, clipId: string): string {
  return `databases/${databaseId}/clips/${clipId}`;
}

// A version of the model; 0: the current one.
export function modelName(databaseId: string, version: number): string {
  return `databases/${databaseId}/models/${version === 0 ? 'current' : version}`;
}

// Last part of a resource name.
export function lastPart(name: string): string {
  return name.slice(name.lastIndexOf('/') + 1);
}

// Id of the database that a resource belongs to; empty if it belongs to none.
export function databaseIdOf(name: string): string {
  const parts = name.split('/');
  return parts[0] === 'databases' ? (parts[1] ?? '') : '';
}

// True for the id of a database: 1 to 63 of a-z, 0-9, '-', '_', beginning with a letter or digit.
export function isDatabaseId(id: string): boolean {
  return /^[a-z0-9][a-z0-9_-]{0,62}$/.test(id);
}

// True for the id of a clip: 1 to 127 of letters, digits, '-', '_', '.'.
export function isClipId(id: string): boolean {
  return /^[A-Za-z0-9_.-]{1,127}$/.test(id);
}
