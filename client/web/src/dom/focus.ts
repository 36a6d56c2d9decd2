// Draws a part of the page anew, gives the focus back to the element with the same `data-key`, and
// keeps the sideways position of a table.
export function keepFocus(node: Element, draw: () => void): void {
  const left = node.querySelector('.table-scroll')?.scrollLeft ?? 0;
  const focused = node.contains(document.activeElement) ? document.activeElement : null;
  const key = focused?.getAttribute('data-key') ?? null;
  draw();
  const scroll = node.querySelector('.table-scroll');
  if (scroll) scroll.scrollLeft = left;
  if (key === null) return;
  const again = node.querySelector<HTMLElement>(`[data-key="${CSS.escape(key)}"]`);
  again?.focus({ preventScroll: true });
}

// Moves the focus to the heading of a view that has replaced another one, so that keys and screen
// readers go on there. A menu with which the user goes through views keeps it: the heading is only
// announced.
export function focusHeading(view: Element, announce: (text: string) => void): void {
  const heading = view.querySelector('h1');
  if (!heading) return;
  if (document.activeElement instanceof HTMLSelectElement) {
    announce(heading.textContent);
    return;
  }
  heading.tabIndex = -1;
  heading.focus();
}
