// Measurements of time count only on a machine that has nothing else to do.
import { loadavg, cpus } from 'node:os';

export const isBusy = () => loadavg()[0] > 1.5 * cpus().length;
