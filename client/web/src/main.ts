import './style/page.css';
import './style/labels.css';
import { Shell } from './shell/shell';

const root = document.getElementById('app');
if (root) void new Shell(root).start();
