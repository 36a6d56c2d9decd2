export type ThemeName = 'light' | 'dark';

const kStorageKey = 'motiondb.theme';

// The light or dark theme: that of the system, until the user chooses one.
export class ThemeSwitch {
  private readonly system = matchMedia('(prefers-color-scheme: dark)');
  private readonly listeners = new Set<(theme: ThemeName) => void>();

  private chosen = readChoice();

  constructor() {
    this.system.addEventListener('change', () => {
      this.apply();
    });
    this.apply();
  }

  get name(): ThemeName {
    return this.chosen ?? (this.system.matches ? 'dark' : 'light');
  }

  toggle(): void {
    this.chosen = this.name === 'dark' ? 'light' : 'dark';
    storeChoice(this.chosen);
    this.apply();
  }

  // Calls the listener at each change. Returns the function that removes it.
  onChange(listener: (theme: ThemeName) => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }

  // The value of a colour of the style sheet, such as --accent.
  color(property: string): string {
    return getComputedStyle(document.documentElement).getPropertyValue(property).trim();
  }

  private apply(): void {
    document.documentElement.dataset['theme'] = this.name;
    for (const listener of [...this.listeners]) listener(this.name);
  }
}

// Reads the stored choice. Storage can be blocked by the browser.
function readChoice(): ThemeName | null {
  try {
    const stored = localStorage.getItem(kStorageKey);
    return stored === 'light' || stored === 'dark' ? stored : null;
  } catch {
    return null;
  }
}

function storeChoice(theme: ThemeName): void {
  try {
    localStorage.setItem(kStorageKey, theme);
  } catch {
    // Without storage the choice lasts until the page is closed.
  }
}
