// Draws a part of the page anew and gives the focus back to the element with the same `data-key`.
// While the pointer presses something in it, does nothing: that would be no click.
export function keepFocus(node: Element, draw: () => void): void {
  if (node.matches(':active')) return;
  const focused = node.contains(document.activeElement) ? document.activeElement : null;
  const key = focused?.getAttribute('data-key') ?? null;
  draw();
  if (key !== null) node.querySelector<HTMLElement>(`[data-key="${CSS.escape(key)}"]`)?.focus();
}
