// Creates elements. Text becomes text nodes only, so names and labels are never read as HTML.

export type Child = Node | string | null | undefined | false;

export type Attributes = Record<string, string | number | boolean | null | undefined>;

// A new element with attributes and children. An attribute that is true is set without a value;
// one that is false, null or undefined is left out.
export function element<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[Name] {
  const node = document.createElement(name);
  setAttributes(node, attributes);
  append(node, children);
  return node;
}

// A new SVG element.
export function svgElement<Name extends keyof SVGElementTagNameMap>(
  name: Name,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[Name] {
  const node = document.createElementNS('http://www.w3.org/2000/svg', name);
  setAttributes(node, attributes);
  append(node, children);
  return node;
}

// Removes all children, then adds others.
export function replaceChildren(node: Element, ...children: Child[]): void {
  node.replaceChildren();
  append(node, children);
}

// A button that does not submit a form.
export function button(
  text: string,
  onClick: () => void,
  attributes: Attributes = {},
): HTMLButtonElement {
  const node = element('button', { type: 'button', ...attributes }, text);
  node.addEventListener('click', onClick);
  return node;
}

// A control below its label.
export function labelled(
  text: string,
  control: HTMLElement,
  attributes: Attributes = {},
): HTMLLabelElement {
  return element('label', { class: 'field', ...attributes }, element('span', {}, text), control);
}

// A list of choices; `selected` is the value of the initial one.
export function selectOf(
  options: readonly (readonly [value: string, text: string])[],
  selected: string,
  attributes: Attributes = {},
): HTMLSelectElement {
  const node = element('select', attributes);
  for (const [value, text] of options) {
    node.append(element('option', { value, selected: value === selected }, text));
  }
  return node;
}

function setAttributes(node: Element, attributes: Attributes): void {
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    node.setAttribute(key, value === true ? '' : String(value));
  }
}

function append(node: Element, children: readonly Child[]): void {
  for (const child of children) {
    if (child === null || child === undefined || child === false) continue;
    node.append(child);
  }
}

// Replaces the names that a list of choices offers. One after the other: there can be more names than
// a call takes arguments.
export function offerNames(list: HTMLDataListElement, names: readonly string[]): void {
  list.replaceChildren();
  for (const name of names) list.append(element('option', { value: name }));
}
