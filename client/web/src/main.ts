import './style/page.css';
import './style/labels.css';
import { Shell } from './shell/shell';

const root = document.getElementById('app');
if (root) {
  const shell = new Shell(root, () => {
    location.reload();
  });
  void shell.start();
}
