import type { Clip } from '../../api/messages';
import { button, element, labelled, selectOf } from '../../dom/element';
import {
  kFieldKinds,
  valuesOf,
  type ClipValues,
  type FieldKind,
  type FieldText,
} from './clip_values';

const kKindTexts = { text: 'text', number: 'number', flag: 'true or false', time: 'time' } as const;

interface FieldRow {
  name: HTMLInputElement;
  kind: HTMLSelectElement;
  text: HTMLInputElement;
}

// Inputs for title, description, tags and fields of a clip.
export class ClipForm {
  readonly node: HTMLFormElement;
  private readonly title: HTMLInputElement;
  private readonly description: HTMLTextAreaElement;
  private readonly tags: HTMLInputElement;
  private readonly rows = new Set<FieldRow>();
  private readonly list = element('div', { class: 'stack' });

  constructor(clip: Clip, save: () => void, cancel: () => void) {
    const values = valuesOf(clip);
    this.title = element('input', { value: values.title, maxlength: 200 });
    this.description = element('textarea', { maxlength: 4000, rows: 3 }, values.description);
    this.tags = element('input', { value: values.tags, spellcheck: 'false' });
    for (const field of values.fields) this.addField(field);
    const add = button('Add field', () => {
      this.addField({ name: '', kind: 'text', text: '' }).name.focus();
    });
    this.node = element(
      'form',
      { class: 'clip-form stack', 'aria-label': 'Edit properties' },
      labelled('Title', this.title),
      labelled('Description', this.description),
      labelled('Tags, with spaces between them', this.tags),
      this.list,
      element(
        'div',
        { class: 'row' },
        element('button', { type: 'submit', class: 'primary' }, 'Save'),
        add,
        button('Cancel', cancel),
      ),
    );
    this.node.addEventListener('submit', (event) => {
      event.preventDefault();
      save();
    });
  }

  get values(): ClipValues {
    return {
      title: this.title.value,
      description: this.description.value,
      tags: this.tags.value,
      fields: [...this.rows].map(({ name, kind, text }) => ({
        name: name.value.trim(),
        kind: kFieldKinds.find((each) => each === kind.value) ?? 'text',
        text: text.value,
      })),
    };
  }

  focus(): void {
    this.title.focus();
  }

  private addField(field: FieldText): FieldRow {
    const kinds = kFieldKinds.map((kind: FieldKind) => [kind, kKindTexts[kind]] as const);
    const row = {
      name: element('input', { value: field.name, maxlength: 63, spellcheck: 'false' }),
      kind: selectOf(kinds, field.kind),
      text: element('input', { value: field.text, maxlength: 1000 }),
    };
    const node = element(
      'div',
      {
        class: 'row',
        role: 'group',
        'aria-label': field.name === '' ? 'New field' : `Field ${field.name}`,
      },
      labelled('Field', row.name),
      labelled('Kind', row.kind),
      labelled('Value', row.text, { class: 'field grow' }),
      button('Remove field', () => {
        this.rows.delete(row);
        node.remove();
      }),
    );
    this.rows.add(row);
    this.list.append(node);
    return row;
  }
}
