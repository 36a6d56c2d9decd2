import { createApi, type Api } from '../api/api';
import { Connection } from '../api/connection';
import { describeError, isConnectionLost } from '../api/errors';
import { readDatabaseIds } from '../api/lists';
import { isDatabaseId } from '../api/resource_names';
import { Traffic } from '../api/server_fetch';
import { logOut, mayActAs, readSession, type Session } from '../api/session';
import { button, element } from '../dom/element';
import { focusHeading } from '../dom/focus';
import { Notice } from '../dom/notice';
import { MotionCache } from '../motion/motion_reader';
import { Header } from './header';
import { openLogin } from './login';
import { hrefOf, parsePlace, type ParsedPlace } from './place';
import type { Route } from './routes';
import { ScriptReload } from './script_reload';
import { checkSession } from './session_check';
import { ThemeSwitch } from './theme';
import type { OpenView, View, ViewContext } from './view';

// Safari permits 100 changes in 30 s.
const kAddressMilliseconds = 350;
const kMotionCacheBytes = 96 * 1024 * 1024;

// The frame around the views: navigation, login, theme, and the state of the connection.
export class Shell {
  private readonly theme = new ThemeSwitch();
  private readonly connection = new Connection(() => readSession());
  private readonly traffic = new Traffic();
  private readonly api: Api = createApi(location.origin, this.connection, this.traffic);
  private readonly motions = new MotionCache(this.api, kMotionCacheBytes);
  private readonly header: Header;
  private readonly banner = new Notice();
  private readonly host = element('main', { id: 'view', tabindex: -1 });
  private readonly speech = element('div', { class: 'visually-hidden', 'aria-live': 'polite' });
  private session: Session = {
    authenticationRequired: false,
    role: null,
    database: '',
    principal: '',
    reason: '',
  };
  private databases: string[] = [];
  private place: ParsedPlace = parsePlace(location.hash);
  private view: View | undefined;
  // The address as `follow` and `writeAddress` know it, and when it was written last.
  private address = '';
  private addressTime = -Infinity;
  private writingAddress: ReturnType<typeof setTimeout> | undefined;
  private opening = 0;
  private readonly scripts: ScriptReload;
  private scriptsFailed = false;
  // A view or the login has been shown since the page was loaded.
  private entered = false;

  // `reload` loads the page again.
  constructor(
    root: HTMLElement,
    private readonly routes: readonly Route[],
    private readonly reload: () => void,
  ) {
    this.scripts = new ScriptReload(reload);
    this.header = new Header(this.theme, routes, {
      changeDatabase: (id) => {
        this.changeDatabase(id);
      },
      leave: () => void this.leave(),
    });
    const skip = button(
      'Skip to content',
      () => {
        this.host.focus();
      },
      { class: 'skip' },
    );
    root.append(skip, this.header.node, this.banner.node, this.host, this.speech);
    this.connection.onChange((state, previous) => {
      if (state === 'lost') this.banner.message('Connection lost. Trying again.');
      else this.banner.clear();
      if (state === 'connected' && previous === 'lost') this.announce('Connection restored.');
      if (state === 'login') this.showLogin(this.connection.loginReason);
      else if (state === 'connected' && previous === 'lost') {
        // Views read again what failed.
        if (this.view) this.databasesChanged();
        else if (this.scriptsFailed) this.scripts.tryOnce();
        else void this.start();
      }
    });
    checkSession({
      connection: this.connection,
      traffic: this.traffic,
      present: () => this.session,
      changed: () => {
        this.flushAddress();
        this.closeView();
        this.announce('The login has changed.');
        void this.start();
      },
    });
    // A link or a new load of the page leaves an address that is complete.
    addEventListener('click', this.flushAddress, { capture: true });
    addEventListener('pagehide', this.flushAddress);
    // After a login, `start` follows the address.
    addEventListener('hashchange', () => {
      if (this.loggedIn) void this.follow(parsePlace(location.hash));
    });
  }

  // Reads the session, then opens the view of the URL.
  async start(): Promise<void> {
    try {
      this.session = await readSession();
      this.connection.succeeded();
    } catch (error) {
      this.connection.failed(error);
      this.banner.error(error, [button('Try again', () => void this.start())]);
      return;
    }
    this.banner.clear();
    if (this.session.role === null) {
      this.showLogin(this.session.reason);
      return;
    }
    await this.readDatabases();
    await this.follow(parsePlace(location.hash));
  }

  private async readDatabases(): Promise<void> {
    try {
      this.databases = await readDatabaseIds(this.api);
    } catch (error) {
      this.databases = this.session.database === '' ? [] : [this.session.database];
      // The banner shows a lost connection already.
      if (!isConnectionLost(error)) this.banner.error(error);
    }
  }

  private databasesChanged(): void {
    void this.readDatabases().then(() => {
      this.drawHeader();
    });
  }

  private showLogin(reason: string): void {
    this.flushAddress();
    this.closeView();
    this.drawHeader();
    setTitle('Log in');
    openLogin(this.host, reason, () => void this.start());
    this.entered = true;
  }

  private async follow(place: ParsedPlace): Promise<void> {
    const route = this.routes.find((candidate) => candidate.view === place.view);
    if (!route) {
      const database = this.databases[0];
      if (place.view === '') {
        if (database !== undefined) {
          location.replace(hrefOf({ view: 'clips', database }));
          return;
        }
        location.replace(hrefOf({ view: 'admin' }));
        return;
      }
    }
    const samePage =
      this.view !== undefined &&
      route?.view === this.place.view &&
      place.database === this.place.database &&
      place.path.join('/') === this.place.path.join('/') &&
      place.query.toString() === this.place.query.toString();
    this.place = place;
    this.address = location.hash;
    if (samePage) return;
    this.closeView();
    this.drawHeader();
    if (place.database !== '' && !this.databases.includes(place.database)) this.databasesChanged();
    setTitle(titleOf(route, place));
    const notice = new Notice();
    this.host.append(notice.node);
    if (!route) {
      notice.error(new Error(`Expected a view of this page, got '${place.view}'.`));
      return;
    }
    if (route.needsDatabase && place.database === '') {
      await this.openFirstDatabase(route, notice);
      return;
    }
    if (place.database !== '' && !isDatabaseId(place.database)) {
      notice.error(new Error(`Expected the id of a database, got '${place.database}'.`));
      return;
    }
    if (!mayActAs(this.session, route.role)) {
      notice.error(new Error(`This view needs the role ${route.role}.`));
      return;
    }
    await this.openView(route, place, notice);
  }

  private async openFirstDatabase(route: Route, notice: Notice): Promise<void> {
    // Somebody can have created one since.
    if (this.databases.length === 0) await this.readDatabases();
    if (!notice.node.isConnected) return;
    const database = this.databases[0];
    if (database === undefined)
      notice.message('The store has no database. Create one with: motiondb create NAME');
    else location.replace(hrefOf({ view: route.view, database }));
  }

  private async openView(route: Route, place: ParsedPlace, notice: Notice): Promise<void> {
    const turn = ++this.opening;
    let module: { open: OpenView };
    try {
      module = await route.load();
    } catch (error) {
      if (turn === this.opening) await this.reportScripts(error, notice);
      return;
    }
    if (turn !== this.opening) return;
    this.scripts.loaded();
    try {
      this.view = module.open(this.host, this.contextOf(), place);
      if (this.entered) focusHeading(this.host, this.announce);
      this.entered = true;
    } catch (error) {
      notice.error(error, [this.reloadButton()]);
    }
  }

  // Scripts of a view could not be loaded: because no server answers, or for another reason.
  private async reportScripts(error: unknown, notice: Notice): Promise<void> {
    const turn = this.opening;
    this.scriptsFailed = true;
    const text =
      'The scripts of this view could not be loaded. If the server answers, a proxy or an ' +
      `extension of the browser can block them. (${describeError(error)?.message ?? ''})`;
    notice.error(new Error(text), [this.reloadButton()]);
    try {
      await readSession();
      if (turn !== this.opening) return;
      // A lost connection ends here, which loads the page again.
      if (this.connection.state === 'lost') this.connection.succeeded();
      else this.scripts.tryOnce();
    } catch (failure) {
      if (turn === this.opening) this.connection.failed(failure);
    }
  }

  private reloadButton(): HTMLElement {
    return button('Try again', this.reload);
  }

  private contextOf(): ViewContext {
    return {
      api: this.api,
      session: this.session,
      connection: this.connection,
      theme: this.theme,
      motions: this.motions,
      navigate: (place) => {
        this.flushAddress();
        location.assign(hrefOf(place));
      },
      setQuery: (values) => {
        this.setQuery(values);
      },
      announce: this.announce,
      setTitle,
    };
  }

  private setQuery(values: Record<string, string | number | null>): void {
    for (const [name, value] of Object.entries(values)) {
      if (value === null || value === '') this.place.query.delete(name);
      else this.place.query.set(name, String(value));
    }
    if (this.writingAddress !== undefined) return;
    const wait = this.addressTime + kAddressMilliseconds - performance.now();
    if (wait > 0) {
      this.writingAddress = setTimeout(() => {
        this.writeAddress();
      }, wait);
    } else {
      this.writeAddress();
    }
  }

  private flushAddress = (): void => {
    if (this.writingAddress === undefined) return;
    clearTimeout(this.writingAddress);
    this.writeAddress();
  };

  // Browsers refuse many changes of the address in a short time, as while a slider is dragged.
  private writeAddress(): void {
    this.writingAddress = undefined;
    this.addressTime = performance.now();
    // The user can have gone to another address, which `follow` does not know yet.
    if (location.hash !== this.address) return;
    history.replaceState(null, '', hrefOf(this.place));
    this.address = location.hash;
  }

  private changeDatabase(database: string): void {
    this.flushAddress();
    const route = this.routes.find((candidate) => candidate.view === this.place.view);
    const view = route?.needsDatabase === true && route.title !== '' ? route.view : 'clips';
    location.assign(hrefOf({ view, database }));
  }

  private closeView(): void {
    ++this.opening;
    clearTimeout(this.writingAddress);
    this.writingAddress = undefined;
    this.view?.close();
    this.view = undefined;
    this.scriptsFailed = false;
    this.host.replaceChildren();
    setTitle('');
  }

  private announce = (text: string): void => {
    this.speech.textContent = text;
  };

  private get loggedIn(): boolean {
    return this.session.role !== null && this.connection.state !== 'login';
  }

  private drawHeader(): void {
    this.header.draw({
      session: this.loggedIn ? this.session : null,
      view: this.place.view,
      database: this.place.database !== '' ? this.place.database : (this.databases[0] ?? ''),
      databases: this.databases,
    });
  }

  private async leave(): Promise<void> {
    this.closeView(); // the server would refuse its calls
    let failure: unknown;
    try {
      await logOut();
    } catch (error) {
      failure = error;
    }
    await this.start();
    if (failure !== undefined) this.banner.error(failure);
  }
}

// Empty: the page shows no view.
function setTitle(text: string): void {
  document.title = text === '' ? 'motiondb' : `${text} - motiondb`;
}

function titleOf(route: Route | undefined, place: ParsedPlace): string {
  if (!route) return 'Unknown view';
  return route.title === '' ? (place.path[0] ?? '') : route.title;
}
