// Choices of the user that the browser stores, such as the theme. If storage is blocked, a choice
// lasts until the page is closed.

export function readChoice(name: string): string | null {
  try {
    return localStorage.getItem(`motiondb.${name}`);
  } catch {
    return null;
  }
}

export function storeChoice(name: string, value: string): void {
  try {
    localStorage.setItem(`motiondb.${name}`, value);
  } catch {
    // Blocked.
  }
}
