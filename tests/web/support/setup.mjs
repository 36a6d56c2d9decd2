// What web_page_test.py started, and the packages of client/web.
import { createRequire } from 'node:module';
import { join } from 'node:path';

const text = process.env.MOTIONDB_WEB_TEST;
if (text === undefined) throw new Error('expected MOTIONDB_WEB_TEST; run web_page_test.py');

/**
 * open, secure: URLs of a server without authentication and of one that needs tokens.
 * openAddress, secureAddress: their gRPC addresses, for the program `motiondb`.
 * openMetrics: URL of the metrics of the open server, without /metrics.
 * adminToken: token of the secure server. models, data: folders of motion; data may be ''.
 * hostile: the label in the database `hostile`; its subject, title, description and a field are the
 * same after a letter. hostileMarker: a marker of this database. chromium, motiondb, motiondbd, root,
 * folder.
 * large: URL `web` and process id of a server with a large database, or null.
 */
export const setup = JSON.parse(text);

// Returns a package of client/web.
export const requirePackage = createRequire(join(setup.root, 'client/web/package.json'));
