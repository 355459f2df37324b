// Opens what make_scene.sh made with Khronos' validator of glTF, three.js and tinyusdz, and compares it, number for
// number, with the NPZ archives, which test/e2e/convert_animations.py compares with the runs themselves.
// usage: node check.mjs FOLDER
import assert from 'node:assert/strict';
import fs from 'node:fs';
import path from 'node:path';
import validator from 'gltf-validator';
import * as THREE from 'three';
import {GLTFLoader} from 'three/examples/jsm/loaders/GLTFLoader.js';
import initTinyUsdz from 'tinyusdz/tinyusdz.js';
import {execFileSync} from 'node:child_process';
import {makeRandom} from './make_random.mjs';
import {readArrays} from './npz.mjs';

const folder = process.argv[2];
const inside = name => path.join(folder, name);
const load = name => new Uint8Array(fs.readFileSync(inside(name)));
globalThis.ProgressEvent ??= class {};

// ---- the validator ----

async function validate(name) {
  const report = await validator.validateBytes(load(name), {
    uri: name, maxIssues: 100, externalResourceFunction: uri => Promise.resolve(load(decodeURIComponent(uri)))});
  const {numErrors, numWarnings, messages} = report.issues;
  assert.equal(numErrors + numWarnings, 0, `${name}: ${JSON.stringify(messages)}`);
}
const files = fs.readdirSync(folder).filter(name => /\.(glb|gltf)$/.test(name));
assert.equal(files.length, 8);
for (const name of files) await validate(name);

// ---- three.js ----

function parse(name) {
  const bytes = load(name);
  return new GLTFLoader().parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '');
}
// Positions at a time as three.js shows them: after its animation, its morph targets and its transforms.
function pose(gltf, time, compareObjects) {
  const mixer = new THREE.AnimationMixer(gltf.scene);
  for (const clip of gltf.animations) {
    const action = mixer.clipAction(clip).setLoop(THREE.LoopOnce);
    action.clampWhenFinished = true; // else the last frame is the first one again
    action.play();
  }
  mixer.setTime(time);
  gltf.scene.updateMatrixWorld(true);
  const positions = [], objects = [];
  gltf.scene.traverse(object => { if (object.isMesh) objects.push(object); });
  if (compareObjects) objects.sort(compareObjects);
  for (const object of objects) {
    if (object.isSkinnedMesh) object.skeleton.update();
    const point = new THREE.Vector3();
    for (let i = 0; i < object.geometry.attributes.position.count; i++) {
      object.getVertexPosition(i, point);
      point.applyMatrix4(object.matrixWorld);
      positions.push(point.x, point.y, point.z);
    }
  }
  return positions;
}
const frameOf = (positions, frame) => {
  const size = positions.shape[1] * 3;
  return positions.data.subarray(frame * size, (frame + 1) * size);
};
// tolerance 0: the same float; else what float rounding of a pose may cost.
function compare(found, expected, tolerance, what) {
  assert.equal(found.length, expected.length, what);
  for (let i = 0; i < found.length; i++)
    assert.ok(tolerance === 0 ? Math.fround(found[i]) === expected[i] : Math.abs(found[i] - expected[i]) <= tolerance,
      `${what}: number ${i} is ${found[i]}, not ${expected[i]}`);
}

const sheet = readArrays(inside('sheet_up.npz'));
const times = sheet.times.data;
const frameCount = times.length;
for (const [name, step] of [['sheet.glb', 1], ['sheet_thin.glb', 4]]) {
  const gltf = await parse(name);
  const mesh = gltf.scene.getObjectByProperty('isMesh', true);
  const targets = mesh.geometry.morphAttributes.position;
  assert.equal(targets.length, Math.ceil(frameCount / step));
  targets.forEach((target, i) => {
    compare(target.array, frameOf(sheet.positions, i * step), 0, `${name}, target ${i}`);
    compare(pose(gltf, Math.fround(times[i * step])), frameOf(sheet.positions, i * step), 0, `${name}, frame ${i * step}`);
  });
  // Normals of a target are unit vectors, to rounding, once they are added to those of the mesh.
  const base = mesh.geometry.attributes.normal.array;
  for (const target of mesh.geometry.morphAttributes.normal)
    for (let i = 0; i < base.length; i += 3)
      assert.ok(Math.abs(Math.hypot(...[0, 1, 2].map(k => base[i + k] + target.array[i + k])) - 1) < 1e-6);
}
// Between frames: halfway, or the frame before.
const all = readArrays(inside('falls.npz'));
const turn = positions => {
  const turned = new Float64Array(positions.length);
  for (let i = 0; i < positions.length; i += 3) turned.set([positions[i], positions[i + 2], -positions[i + 1]], i);
  return turned;
};
const half = (times[3] + times[4]) / 2;
const stepped = pose(await parse('falls_step.glb'), half);
compare(stepped, turn(frameOf(all.positions, 3)), 1e-6, 'step');
const between = frameOf(all.positions, 3).map((x, i) => (x + frameOf(all.positions, 4)[i]) / 2);
compare(pose(await parse('falls.glb'), half), turn(between), 1e-5, 'linear');
for (let frame = 0; frame < frameCount; frame++)
  compare(pose(await parse('falls.glb'), times[frame]), turn(frameOf(all.positions, frame)), 1e-6, `falls.glb, frame ${frame}`);
compare(pose(await parse('falls_0006.glb'), 0), turn(frameOf(all.positions, 6)), 1e-6, 'falls_0006.glb');
const falls = await parse('falls.glb');
const boxes = [];
falls.scene.traverse(object => { if (object.name.startsWith('box')) boxes.push(object); });
assert.equal(boxes.length, 3);
assert.ok(boxes.every(box => box.geometry === boxes[0].geometry), 'copies share one geometry');
const points = await parse('points.glb');
const targets = points.scene.getObjectByProperty('isPoints', true).geometry.morphAttributes.position;
targets.forEach((target, i) => compare(target.array, frameOf(sheet.positions, i), 0, `points.glb, target ${i}`));

// ---- what others write: tulle convert against three.js ----

const randomCount = 60;
for (let seed = 1; seed <= randomCount; seed++) {
  const document = makeRandom(seed);
  fs.writeFileSync(inside('random.gltf'), JSON.stringify(document));
  execFileSync(process.env.TULLE, ['convert', inside('random.gltf'), inside('random.npz'), '--up', 'y', '--double'], {stdio: 'pipe'});
  const read = readArrays(inside('random.npz'));
  const gltf = await parse('random.gltf');
  // three.js goes through its tree, the file's nodes have numbers.
  const order = new Map(document.nodes.map((node, i) => [node.name, i]));
  const numberOf = object => order.get(object.name) ?? order.get(object.parent.name);
  for (let frame = 0; frame < read.times.data.length; frame++)
    compare(frameOf(read.positions, frame), pose(gltf, read.times.data[frame], (a, b) => numberOf(a) - numberOf(b)), 2e-5,
      `random file ${seed} at ${read.times.data[frame]} s`);
}

// ---- tinyusdz ----

// It is built for pages and looks for one.
Object.assign(process, {type: 'renderer'});
Object.assign(globalThis, {window: globalThis, document: {currentScript: null}});
const wasm = new URL('./node_modules/tinyusdz/tinyusdz.wasm', import.meta.url);
const usd = await initTinyUsdz({wasmBinary: fs.readFileSync(wasm)});
function open(name, how) {
  const loader = new usd.TinyUSDZLoaderNative();
  assert.ok(loader[how](load(name), name), `${name}: ${loader.error()}`);
  return loader;
}
// Numbers of the time samples of an attribute in what tinyusdz prints of a layer.
function samples(text, attribute) {
  const begin = text.indexOf(`${attribute}.timeSamples = {`);
  assert.ok(begin >= 0, attribute);
  const body = text.slice(begin, text.indexOf('}', begin));
  return [...body.matchAll(/([-\d.e+]+): (\[[^\]]*\])/g)].map(match => ({
    code: Number(match[1]), values: match[2].match(/-?[\d.]+(e[-+]?\d+)?/g).map(Number)}));
}
const still = readArrays(inside('sheet.npz'));
const layer = open('sheet.usda', 'loadAsLayerFromBinary').layerToString();
const found = samples(layer, 'points');
assert.equal(found.length, frameCount);
found.forEach(({code, values}, frame) => { // printed with six digits
  assert.equal(code, frame);
  compare(values, frameOf(still.positions, frame), 1e-6, `sheet.usda, frame ${frame}`);
});
for (const name of ['extent', 'normals', 'velocities']) assert.equal(samples(layer, name).length, frameCount, name);
for (const fact of ['upAxis = "Z"', 'timeCodesPerSecond = 100', 'endTimeCode = 12', 'metersPerUnit = 1'])
  assert.ok(layer.includes(fact), fact);
for (let frame = 0; frame < frameCount; frame++) { // as numbers: the same floats
  const mesh = open(`sheet_${String(frame).padStart(4, '0')}.usda`, 'loadFromBinary').getMesh(0);
  compare(mesh.points, frameOf(still.positions, frame), 0, `sheet, frame ${frame} alone`);
  assert.equal(mesh.displayName, 'sheet');
  assert.deepEqual([...mesh.faceVertexIndices], [...still.triangles.data].map(Number));
}
const scene = open('falls.usda', 'loadAsLayerFromBinary');
assert.ok(scene.hasReferences() && scene.composeReferences() && scene.layerToRenderScene(), scene.error());
const world = scene.getRootNode(0);
assert.deepEqual(world.children.map(node => node.primName), ['sheet', 'floor', 'box_000', 'box_001', 'box_002']);
world.children.slice(2).forEach((node, i) => { // each box shows the same mesh at its own place
  const mesh = scene.getMesh(node.children[0].contentId);
  const from = 3 * Number(all.first_vertices.data[2 + i]);
  const placed = mesh.points.map((x, k) => x + node.localMatrix[12 + k % 3]);
  compare(placed, all.positions.data.subarray(from, from + placed.length), 1e-6, node.primName);
});
assert.ok(open('seam.usda', 'loadFromBinary').numMeshes() === 1);
console.log(`${files.length} glTF files without errors or warnings; three.js and tinyusdz read the same numbers`);
console.log(`${randomCount} random glTF files are read as three.js reads them`);
