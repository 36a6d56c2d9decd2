import { describeError } from '../../api/errors';
import { button, element, labelled } from '../../dom/element';
import { Notice } from '../../dom/notice';
import { errorIndex } from './filter_text';

export interface FilterBoxEvents {
  apply(filter: string, search: string): void;
}

// The boxes of the filter expression and of the full-text search. An error of the filter is shown
// with its place in the text.
export class FilterBox {
  readonly node: HTMLFormElement;
  private readonly filter: HTMLInputElement;
  private readonly search: HTMLInputElement;
  private readonly notice = new Notice();
  // The user has applied the text and has no answer yet.
  private applied = false;

  constructor(filter: string, search: string, events: FilterBoxEvents) {
    this.filter = element('input', {
      type: 'search',
      value: filter,
      spellcheck: 'false',
      autocomplete: 'off',
      maxlength: 4096,
      placeholder: 'label = walk AND duration >= 2.5s',
    });
    this.search = element('input', { type: 'search', value: search, maxlength: 1000 });
    this.node = element(
      'form',
      { class: 'filter stack', role: 'search' },
      element(
        'div',
        { class: 'row' },
        labelled('Filter', this.filter, { class: 'field grow' }),
        labelled('Search words', this.search, { class: 'field grow' }),
        element('button', { type: 'submit', class: 'primary' }, 'Apply'),
        button('Clear', () => {
          this.set('', '');
          events.apply('', '');
        }),
      ),
      this.notice.node,
    );
    this.node.addEventListener('submit', (event) => {
      event.preventDefault();
      this.filter.value = this.filter.value.trim();
      this.applied = true;
      events.apply(this.filter.value, this.search.value.trim());
    });
  }

  set(filter: string, search: string): void {
    this.filter.value = filter;
    this.search.value = search;
    this.clearError();
  }

  clearError(): void {
    this.applied = false;
    this.notice.clear();
    this.filter.removeAttribute('aria-invalid');
  }

  // Shows an error of the list that was read with the filter `text`; one of the filter marks its
  // place. The user can have changed the text since, so it is selected only after `Apply`.
  showError(error: unknown, text: string): void {
    const selects = this.applied && this.filter.value === text;
    this.applied = false;
    const index = errorIndex(text, describeError(error)?.message ?? '');
    if (index === undefined) {
      this.notice.error(error);
      return;
    }
    this.filter.setAttribute('aria-invalid', 'true');
    if (selects) this.filter.setSelectionRange(index, text.length);
    this.notice.error(error, [
      element(
        'p',
        { class: 'filter-error' },
        text.slice(0, index),
        element('mark', {}, text.slice(index) === '' ? ' ' : text.slice(index)),
      ),
    ]);
  }
}
