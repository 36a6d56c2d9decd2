import { readChoice, storeChoice } from '../dom/browser_storage';

export type ThemeName = 'light' | 'dark';

// The light or dark theme: that of the system, until the user chooses one.
export class ThemeSwitch {
  private readonly system = matchMedia('(prefers-color-scheme: dark)');
  private readonly listeners = new Set<(theme: ThemeName) => void>();

  private chosen = chosenTheme();

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
    storeChoice('theme', this.chosen);
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

function chosenTheme(): ThemeName | null {
  const stored = readChoice('theme');
  return stored === 'light' || stored === 'dark' ? stored : null;
}
