const kReloadMark = 'motiondb.reloaded';

// Loads the page again if scripts of a view could not be loaded: browsers remember that they failed.
// Not again until scripts are loaded: otherwise scripts that a proxy or the browser blocks would load
// the page again and again. The mark of a new load is in the storage of the tab.
export class ScriptReload {
  constructor(private readonly reload: () => void) {}

  // Does nothing if the page was loaded again already, or if storage is blocked.
  tryOnce(): void {
    try {
      if (sessionStorage.getItem(kReloadMark) !== null) return;
      sessionStorage.setItem(kReloadMark, '1');
    } catch {
      return;
    }
    this.reload();
  }

  // Call when scripts of a view are loaded.
  loaded(): void {
    try {
      sessionStorage.removeItem(kReloadMark);
    } catch {
      // Blocked.
    }
  }
}
