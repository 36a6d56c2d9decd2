import { pagesOf } from '../../api/lists';
import { Role, type Token } from '../../api/messages';
import { databaseName, lastPart } from '../../api/resource_names';
import type { Disposer } from '../../dom/disposer';
import { button, element, labelled, replaceChildren, selectOf } from '../../dom/element';
import { keepFocus } from '../../dom/focus';
import { time } from '../../dom/format';
import { Notice } from '../../dom/notice';
import { tableOf } from '../../dom/table';
import type { ViewContext } from '../../shell/view';

const kRoles = [
  ['1', 'reader'],
  ['2', 'ingester'],
  ['3', 'admin'],
] as const;

// Tokens: create, list and revoke. Only the answer to a creation has the secret.
export class TokensPanel {
  readonly node: HTMLElement;
  private readonly notice = new Notice();
  private readonly secret = new Notice();
  private readonly list = element('div');
  private readonly submit: HTMLButtonElement;
  private readonly role = selectOf(kRoles, '1');
  private readonly database = element('input', { placeholder: 'all' });
  private readonly description = element('input', { maxlength: 200 });
  private readonly days = element('input', {
    type: 'number',
    min: 1,
    max: 36500,
    placeholder: 'never',
  });

  constructor(
    private readonly context: ViewContext,
    private readonly disposer: Disposer,
  ) {
    this.submit = element('button', { type: 'submit', class: 'primary' }, 'Create token');
    const form = element(
      'form',
      { class: 'row' },
      labelled('Role', this.role),
      labelled('Database', this.database),
      labelled('Purpose', this.description),
      labelled('Expires after days', this.days),
      this.submit,
    );
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      void this.create();
    });
    this.node = element(
      'section',
      { class: 'panel stack', 'aria-label': 'Tokens' },
      element('h2', {}, 'Tokens'),
      form,
      this.secret.node,
      this.notice.node,
      this.list,
    );
    void this.read();
  }

  // One at a time: the answer to a second one would replace the secret of the first.
  private async create(): Promise<void> {
    if (this.submit.disabled) return;
    this.submit.disabled = true;
    this.secret.clear();
    this.notice.clear();
    const database = this.database.value.trim();
    const days = Number(this.days.value);
    try {
      const { secret } = await this.context.api.access.createToken(
        {
          token: {
            role: roleOf(this.role.value),
            database: database === '' ? '' : databaseName(database),
            description: this.description.value.trim(),
          },
          ...(days > 0 ? { ttl: { seconds: BigInt(Math.round(days * 86400)) } } : {}),
        },
        { signal: this.disposer.signal },
      );
      this.secret.message('Copy the token now. The server does not show it again.', [
        element('p', {}, element('code', { class: 'secret' }, secret)),
        button('Done', () => {
          this.secret.clear();
        }),
      ]);
      await this.read();
    } catch (error) {
      this.notice.error(error);
    } finally {
      this.submit.disabled = false;
    }
  }

  private async read(): Promise<void> {
    try {
      const tokens: Token[] = [];
      const { signal } = this.disposer;
      for await (const page of pagesOf((request) =>
        this.context.api.access.listTokens(request, { signal }),
      )) {
        tokens.push(...page.tokens);
      }
      this.notice.clear();
      this.draw(tokens);
    } catch (error) {
      this.notice.error(error);
      this.context.connection.whenRestored(error, this.disposer.signal, () => void this.read());
    }
  }

  private draw(tokens: readonly Token[]): void {
    keepFocus(this.list, () => {
      replaceChildren(
        this.list,
        tableOf(
          'Tokens',
          [
            { title: 'Token' },
            { title: 'Role' },
            { title: 'Database' },
            { title: 'Purpose' },
            { title: 'Created' },
            { title: 'Expires' },
            { title: 'Revoked' },
          ],
          tokens.map((token) => [
            lastPart(token.name),
            kRoles[token.role - 1]?.[1] ?? '',
            token.database === '' ? 'all' : lastPart(token.database),
            token.description,
            time(token.createTime),
            token.expireTime ? time(token.expireTime) : 'never',
            token.revokeTime ? time(token.revokeTime) : this.revokeButton(token),
          ]),
        ),
      );
    });
  }

  private revokeButton(token: Token): HTMLElement {
    const node = button(
      'Revoke',
      () => {
        node.disabled = true;
        this.notice.clear();
        this.context.api.access
          .revokeToken({ name: token.name }, { signal: this.disposer.signal })
          .then(() => this.read())
          .catch((error: unknown) => {
            node.disabled = false;
            this.notice.error(error);
          });
      },
      { 'aria-label': `Revoke ${lastPart(token.name)}`, 'data-key': token.name },
    );
    return node;
  }
}

function roleOf(value: string): Role {
  if (value === '3') return Role.ADMIN;
  return value === '2' ? Role.INGESTER : Role.READER;
}
