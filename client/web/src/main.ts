import './style/theme.css';
import './style/page.css';
import './style/labels.css';
import { kRoutes } from './shell/routes';
import { Shell } from './shell/shell';

const root = document.getElementById('app');
if (root) {
  const shell = new Shell(root, kRoutes, () => {
    location.reload();
  });
  void shell.start();
}
