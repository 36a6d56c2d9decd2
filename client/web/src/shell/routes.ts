import type { RoleName } from '../api/session';
import type { OpenView } from './view';

export interface Route {
  // First part of the URL.
  readonly view: string;
  // Text of the navigation; empty: the view is not in the navigation.
  readonly title: string;
  // False for a view of the whole server.
  readonly needsDatabase: boolean;
  readonly role: RoleName;
  readonly load: () => Promise<{ open: OpenView }>;
}

// One line for each view, in the order of the navigation.
export const kRoutes: readonly Route[] = [
  {
    view: 'clips',
    title: 'Clips',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/clips/clips_view'),
  },
  {
    view: 'clip',
    title: '',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/clip/clip_view'),
  },
  {
    view: 'database',
    title: 'Database',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/database/database_view'),
  },
  {
    view: 'query',
    title: 'Query',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/query/query_view'),
  },
  {
    view: 'plan',
    title: 'Plan',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/plan/plan_view'),
  },
  {
    view: 'live',
    title: 'Live',
    needsDatabase: true,
    role: 'reader',
    load: () => import('../views/live/live_view'),
  },
  {
    view: 'admin',
    title: 'Server',
    needsDatabase: false,
    role: 'reader',
    load: () => import('../views/admin/admin_view'),
  },
];
