// Puts a page into the background and back. The browser of the tests shows all its pages.

// Lets the pages that `page` opens later be hidden.
export function recordVisibility(page) {
  return page.addInitScript(() => {
    let hidden = false;
    Object.defineProperty(Document.prototype, 'hidden', { get: () => hidden });
    window.setHidden = (value) => {
      hidden = value;
      document.dispatchEvent(new Event('visibilitychange'));
    };
  });
}

export const hide = (page) => page.evaluate(() => window.setHidden(true));
export const show = (page) => page.evaluate(() => window.setHidden(false));
