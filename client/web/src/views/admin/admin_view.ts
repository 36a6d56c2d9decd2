import '../../style/admin.css';
import { mayActAs } from '../../api/session';
import { Disposer } from '../../dom/disposer';
import { element } from '../../dom/element';
import type { OpenView } from '../../shell/view';
import { AuditPanel } from './audit_panel';
import { BackupPanel } from './backup_panel';
import { OperationsPanel } from './operations_panel';
import { StatusPanel } from './status_panel';
import { TokensPanel } from './tokens_panel';

// State and administration of the server; each section is there if the caller's role permits it. The
// token of one database permits nothing about the whole server.
export const open: OpenView = (host, context) => {
  const disposer = new Disposer();
  const server = context.session.database === '';
  const admin = server && mayActAs(context.session, 'admin');
  host.append(
    element(
      'div',
      { class: 'stack' },
      element('h1', {}, 'Server'),
      server && new StatusPanel(context, disposer).node,
      new OperationsPanel(context, disposer).node,
      new BackupPanel(context, disposer, admin).node,
      admin && new TokensPanel(context, disposer).node,
      admin && new AuditPanel(context, disposer).node,
    ),
  );
  return {
    close: () => {
      disposer.dispose();
    },
  };
};
