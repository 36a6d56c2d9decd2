import type { Api } from '../api/api';
import type { Connection } from '../api/connection';
import type { Session } from '../api/session';
import type { MotionCache } from '../motion/motion_reader';
import type { Place } from './place';
import type { ThemeSwitch } from './theme';

// What the shell gives to a view.
export interface ViewContext {
  readonly api: Api;
  readonly session: Session;
  readonly connection: Connection;
  readonly theme: ThemeSwitch;
  // Motion of clips, bounded in memory and shared by all views.
  readonly motions: MotionCache;
  // Opens another place, with an entry in the browser's history.
  navigate(place: Place): void;
  // Changes the query part of the present URL without opening the view again, so that the URL can
  // be shared. A value that is null or empty removes its name.
  setQuery(values: Record<string, string | number | null>): void;
  // Says a text to screen readers.
  announce(text: string): void;
  // Title of the page, before "motiondb".
  setTitle(text: string): void;
}

// The part of the URL that belongs to a view.
export interface ViewParams {
  // Id of the database; empty for a view of the whole server.
  readonly database: string;
  // Parts of the path after the database, decoded.
  readonly path: readonly string[];
  readonly query: URLSearchParams;
}

// An open view.
export interface View {
  // Ends calls, timers and listeners, and releases memory of the graphics processor. The shell
  // empties the host.
  close(): void;
}

// A module of a view exports this function.
export type OpenView = (host: HTMLElement, context: ViewContext, params: ViewParams) => View;
