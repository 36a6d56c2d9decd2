import type { Clip } from '../../api/messages';
import { lastPart } from '../../api/resource_names';
import { button, element, replaceChildren } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { count, seconds, time } from '../../dom/format';
import { hrefOf } from '../../shell/place';
import { labelClass } from '../../drawing/labels';
import { nextOrder, sortDirection } from './clip_list_state';
import type { Thumbnails } from './thumbnail';

const kColumns = [
  { title: 'Clip', field: 'name' },
  { title: 'Label', field: 'label' },
  { title: 'Subject', field: 'subject' },
  { title: 'Title', field: 'title' },
  { title: 'Tags', field: '' },
  { title: 'Duration', field: 'duration', number: true },
  { title: 'Frames', field: 'frames', number: true },
  { title: 'Stored', field: 'create_time' },
];

export interface ClipTableOptions {
  database: string;
  thumbnails: Thumbnails;
  // Deletes a clip; false: it could not. Null: the caller may not delete.
  remove: ((clip: Clip) => Promise<boolean>) | null;
  order(orderBy: string): void;
}

// The clips of a page.
export class ClipTable {
  readonly node = element('div', { class: 'table-scroll' });
  // Id of the clip with the button `Really delete`; empty: none.
  private asked = '';
  private drawing = false;

  constructor(private readonly options: ClipTableOptions) {}

  // `orderBy` is null for the results of a search, which have an order of their own.
  draw(clips: readonly Clip[], orderBy: string | null): void {
    const { thumbnails, remove } = this.options;
    thumbnails.clear();
    if (!clips.some((clip) => lastPart(clip.name) === this.asked)) this.asked = '';
    const head = element(
      'tr',
      {},
      element('th', { scope: 'col' }, element('span', { class: 'visually-hidden' }, 'Picture')),
    );
    for (const column of kColumns) head.append(this.heading(column, orderBy));
    if (remove)
      head.append(
        element('th', { scope: 'col' }, element('span', { class: 'visually-hidden' }, 'Actions')),
      );
    const body = element('tbody', {}, ...clips.map((clip) => this.row(clip)));
    this.drawing = true;
    keepFocus(this.node, () => {
      replaceChildren(
        this.node,
        element('table', { class: 'clips' }, element('thead', {}, head), body),
        clips.length === 0 && element('p', { class: 'hint' }, 'No clips.'),
      );
    });
    this.drawing = false;
  }

  private heading(column: (typeof kColumns)[number], orderBy: string | null): HTMLElement {
    const { title, field } = column;
    const cell = element('th', { scope: 'col', class: column.number === true ? 'number' : null });
    if (field === '' || orderBy === null) {
      cell.append(title);
      return cell;
    }
    const direction = sortDirection(orderBy, field);
    if (direction) cell.setAttribute('aria-sort', direction);
    const arrow = direction === null ? '' : direction === 'ascending' ? ' ▲' : ' ▼';
    cell.append(
      button(
        `${title}${arrow}`,
        () => {
          this.options.order(nextOrder(orderBy, field));
        },
        { class: 'sort', 'data-key': `sort ${field}` },
      ),
    );
    return cell;
  }

  private row(clip: Clip): HTMLElement {
    const id = lastPart(clip.name);
    const href = hrefOf({ view: 'clip', database: this.options.database, path: [id] });
    const label =
      clip.label === ''
        ? ''
        : element('span', { class: `label ${labelClass(clip.label)}` }, clip.label);
    const row = element(
      'tr',
      {},
      element(
        'td',
        {},
        element(
          'a',
          { href, tabindex: -1, 'aria-hidden': 'true' },
          this.options.thumbnails.create(clip),
        ),
      ),
      element('td', {}, element('a', { href, 'data-key': id }, id)),
      element('td', {}, label),
      element('td', {}, clip.subject),
      element('td', {}, clip.title),
      element('td', {}, clip.tags.join(', ')),
      element('td', { class: 'number' }, seconds(clip.durationSeconds)),
      element('td', { class: 'number' }, count(clip.frameCount)),
      element('td', { class: 'nowrap' }, time(clip.createTime)),
    );
    if (this.options.remove) row.append(element('td', {}, this.deleteButton(clip, id)));
    return row;
  }

  // The first click asks, the second one deletes.
  private deleteButton(clip: Clip, id: string): HTMLElement {
    const node = button(
      'Delete',
      () => {
        node.disabled = this.asked === id;
        this.asked = node.disabled ? '' : id;
        show();
        if (!node.disabled) return;
        void this.options.remove?.(clip).then((removed) => {
          node.disabled = removed;
        });
      },
      { 'data-key': `delete ${id}` },
    );
    const show = () => {
      node.textContent = this.asked === id ? 'Really delete' : 'Delete';
      node.setAttribute('aria-label', `${node.textContent} ${id}`);
    };
    node.addEventListener('blur', () => {
      if (this.drawing) return;
      this.asked = '';
      show();
    });
    show();
    return node;
  }
}
