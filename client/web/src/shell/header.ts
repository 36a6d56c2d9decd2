import { mayActAs, type Session } from '../api/session';
import { button, element, replaceChildren } from '../dom/element';
import { keepFocus } from '../dom/focus';
import { hrefOf } from './place';
import type { Route } from './routes';
import type { ThemeSwitch } from './theme';

// What the header shows.
export interface HeaderState {
  // Null without a login.
  session: Session | null;
  view: string;
  database: string;
  databases: readonly string[];
}

export interface HeaderEvents {
  changeDatabase(id: string): void;
  leave(): void;
}

// Navigation between views and databases, theme, and logging out.
export class Header {
  readonly node: HTMLElement;
  private readonly navigation = element('nav', { 'aria-label': 'Views' });
  private readonly database = element('select', { 'aria-label': 'Database' });
  private readonly tools = element('div', { class: 'tools' });
  private readonly themeButton: HTMLButtonElement;

  constructor(
    theme: ThemeSwitch,
    private readonly routes: readonly Route[],
    private readonly events: HeaderEvents,
  ) {
    this.node = element(
      'header',
      { class: 'shell' },
      element('a', { class: 'brand', href: '#/' }, 'motiondb'),
      this.database,
      this.navigation,
      this.tools,
    );
    this.themeButton = button(
      '',
      () => {
        theme.toggle();
      },
      { title: 'Light or dark theme' },
    );
    // Also when the theme of the system changes.
    const offerOther = () => {
      this.themeButton.textContent = theme.name === 'dark' ? 'Light' : 'Dark';
    };
    offerOther();
    theme.onChange(offerOther);
    this.database.addEventListener('change', () => {
      events.changeDatabase(this.database.value);
    });
  }

  draw(state: HeaderState): void {
    const { session, database, databases } = state;
    const ids =
      database === '' || databases.includes(database) ? databases : [database, ...databases];
    replaceChildren(
      this.database,
      ...ids.map((id) => element('option', { value: id, selected: id === database }, id)),
    );
    this.database.hidden = session === null || ids.length === 0;
    const routes = this.routes.filter(
      (route) => session !== null && route.title !== '' && mayActAs(session, route.role),
    );
    const links = routes.map((route) =>
      element(
        'a',
        {
          href: hrefOf(route.needsDatabase ? { view: route.view, database } : { view: route.view }),
          'aria-current': route.view === state.view ? 'page' : null,
          'data-key': route.view,
        },
        route.title,
      ),
    );
    keepFocus(this.navigation, () => {
      replaceChildren(this.navigation, ...links);
    });
    replaceChildren(
      this.tools,
      session !== null && element('span', { class: 'hint' }, session.principal),
      this.themeButton,
      session?.authenticationRequired === true &&
        button('Log out', () => {
          this.events.leave();
        }),
    );
  }
}
