import type { Facet } from '../../api/messages';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { count } from '../../dom/format';
import { facetTerm, hasTerm, toggleTerm } from './filter_text';

const kShownValues = 12;

// Values of fields with their counts; a click adds the value to the filter or removes it.
export class FacetPanel {
  readonly node = element('aside', { class: 'facets', 'aria-label': 'Values of the listed clips' });

  // Fields of which all values are shown.
  private readonly expanded = new Set<string>();

  constructor(private readonly apply: (filter: string) => void) {}

  draw(facets: readonly Facet[], filter: string): void {
    const groups = facets
      .filter((facet) => facet.values.length > 0)
      .map((facet) => this.groupOf(facet, filter));
    keepFocus(this.node, () => {
      replaceChildren(this.node, ...groups);
    });
  }

  private groupOf(facet: Facet, filter: string): HTMLElement {
    const list = element('ul', {});
    facet.values.forEach((value, index) => {
      const term = facetTerm(facet.field, value.value);
      const chosen = hasTerm(filter, term);
      const choice = button(
        value.value,
        () => {
          this.apply(toggleTerm(filter, term));
        },
        { 'aria-pressed': String(chosen), class: 'facet', 'data-key': term },
      );
      choice.append(element('span', { class: 'facet-count' }, ` ${count(value.clipCount)}`));
      const hidden = index >= kShownValues && !chosen && !this.expanded.has(facet.field);
      list.append(element('li', { hidden }, choice));
    });
    const more = this.expanded.has(facet.field) ? 0 : facet.values.length - kShownValues;
    const group = element('section', {}, element('h2', {}, facet.field), list);
    if (more > 0) {
      const show = button(`${count(more)} more`, () => {
        this.expanded.add(facet.field);
        for (const item of list.children) item.removeAttribute('hidden');
        show.remove();
      });
      group.append(show);
    }
    return group;
  }
}
