// Checks a GLB file with three.js and the glTF validator of Khronos:
//   node check_glb.mjs FILE.glb EXPECTED.json
// EXPECTED.json: {"frame_rate_hz": 60, "positions": [[[x, y, z], ...], ...]}: the world position
// (m, y up) of the first nodes of the file in each frame. Needs the npm packages three and
// gltf-validator in the folder NODE_MODULES, default ./node_modules. Exits with 1 if a position
// differs by more than 1e-5 of the figure's size (at least 1 m) or the validator reports an error.
import fs from 'node:fs';
import path from 'node:path';
import {createRequire} from 'node:module';
import {pathToFileURL} from 'node:url';

const [glbPath, expectedPath] = process.argv.slice(2);
const modules = path.resolve(process.env.NODE_MODULES ?? 'node_modules');
const fromModules = createRequire(path.join(modules, 'x.js'));
const load = (file) => import(pathToFileURL(path.join(modules, file)));

const bytes = new Uint8Array(fs.readFileSync(glbPath));
const expected = JSON.parse(fs.readFileSync(expectedPath, 'utf8'));
const frames = expected.positions;

const report = await fromModules('gltf-validator').validateBytes(bytes, {maxIssues: 100});
for (const issue of report.issues.messages) {
  const {code, severity, pointer, message} = issue;
  console.log(`validator: ${code} (severity ${severity}) ${pointer}: ${message}`);
}

globalThis.self ??= globalThis;  // three.js expects a browser or worker
const THREE = await load('three/build/three.module.js');
const {GLTFLoader} = await load('three/examples/jsm/loaders/GLTFLoader.js');
const gltf = await new GLTFLoader().parseAsync(bytes.buffer, '');
const joints = await Promise.all(frames[0].map((_, j) => gltf.parser.getDependency('node', j)));
const mixer = new THREE.AnimationMixer(gltf.scene);
const action = mixer.clipAction(gltf.animations[0]);
action.setLoop(THREE.LoopOnce);
action.clampWhenFinished = true;
action.play();

let size = 0;
let worst = 0;
const found = new THREE.Vector3();
frames.forEach((positions, frame) => {
  mixer.setTime(Math.fround(frame / expected.frame_rate_hz));  // the time of a key
  gltf.scene.updateMatrixWorld(true);
  positions.forEach((position, j) => {
    const wanted = new THREE.Vector3(...position);
    size = Math.max(size, wanted.distanceTo(new THREE.Vector3(...positions[0])));
    worst = Math.max(worst, found.setFromMatrixPosition(joints[j].matrixWorld).distanceTo(wanted));
  });
});
const {numErrors, numWarnings} = report.issues;
const passed = numErrors === 0 && gltf.animations.length === 1 && worst <= 1e-5 * Math.max(size, 1);
console.log(`${path.basename(glbPath)}: ${frames.length} frames, ${joints.length} joints, ` +
    `figure of ${size.toFixed(3)} m: differs by ${worst.toExponential(2)} m; ` +
    `validator: ${numErrors} errors, ${numWarnings} warnings`);
process.exit(passed ? 0 : 1);
