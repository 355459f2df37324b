// Scenes, runs and large meshes for the checks of the page, in the folder `work`.
import fs from 'node:fs';
import path from 'node:path';
import { run, work } from './harness.mjs';

// A sheet falls on a ball.
export const WATCHED = `title: a sheet on a ball
time: {step: 1/90 s, duration: 1.2 s, steps_per_frame: 3}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [1, 1], resolution: [25, 25]}
    translate: [0, 0, 0.33]
    material: {preset: cotton}
obstacles:
  - name: ball
    mesh: {shape: sphere, radius: 0.3, resolution: [8]}
`;

// A sheet hangs by its upper edge; a block and a ball stand beside it.
export const LIVE = `title: a curtain
time: {step: 1/90 s, duration: 4 s, steps_per_frame: 3}
cloth:
  - name: curtain
    mesh: {shape: rectangle, size: [1, 1], resolution: [17, 17]}
    rotate: [0, 90 deg, 0]
    translate: [0, 0, 1]
    material: {preset: cotton}
    pins: [{box: {min: [-0.1, -1, 1.45], max: [0.1, 1, 1.6]}}]
obstacles:
  - name: ground
    mesh: {shape: plane, size: [4, 4]}
    friction: 0.5
  - name: block
    mesh: {shape: box, size: [0.3, 0.3, 0.3]}
    translate: [0.8, 0, 0.7]
  - name: ball
    mesh: {shape: sphere, radius: 0.1, resolution: [4]}
    translate: [-0.6, 0.5, 0.12]
    dynamic: {mass: 0.2 kg}
`;

const LONG = `title: ten thousand frames
time: {step: 1/90 s, duration: 111.1 s, steps_per_frame: 1}
cloth:
  - name: flag
    mesh: {shape: rectangle, size: [1, 1], resolution: [5, 5]}
    rotate: [0, 90 deg, 0]
    pins: [{box: {min: [-0.1, -1, 0.45], max: [0.1, 1, 0.6]}}]
wind: {velocity: [3, 1, 0], gust_strength: 2}
`;

// An obstacle that waves, of about so many triangles, over a small cloth.
function writeLarge(name, triangleCount, frameCount) {
  const n = Math.round(Math.sqrt(triangleCount / 2)) + 1,
    lines = [],
    at = (i, j) => [2 * (i / (n - 1) - 0.5), 2 * (j / (n - 1) - 0.5)];
  for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) lines.push(`v ${at(i, j).join(' ')} 0`);
  for (let i = 1; i < n; i++)
    for (let j = 1; j < n; j++) {
      const a = n * i + j + 1;
      lines.push(`f ${a} ${a - 1} ${a - n}`, `f ${a - 1} ${a - n - 1} ${a - n}`);
    }
  fs.writeFileSync(path.join(work, `${name}.obj`), `${lines.join('\n')}\n`);
  const head = Buffer.alloc(32);
  head.write('POINTCACHE2\0', 'latin1');
  head.writeInt32LE(1, 12);
  head.writeInt32LE(n * n, 16);
  head.writeFloatLE(0, 20);
  head.writeFloatLE(1, 24);
  head.writeInt32LE(frameCount, 28);
  const numbers = new Float32Array(3 * n * n * frameCount);
  let place = 0;
  for (let frame = 0; frame < frameCount; frame++)
    for (let i = 0; i < n; i++)
      for (let j = 0; j < n; j++) {
        const [x, y] = at(i, j);
        numbers[place++] = x;
        numbers[place++] = y;
        numbers[place++] = 0.05 * Math.sin(6 * x + 0.4 * frame) * Math.cos(5 * y);
      }
  fs.writeFileSync(path.join(work, `${name}.pc2`), Buffer.concat([head, Buffer.from(numbers.buffer)]));
  fs.writeFileSync(
    path.join(work, `${name}.yaml`),
    `title: ${triangleCount} triangles
time: {step: 1/30 s, duration: ${(frameCount - 1) / 30} s, steps_per_frame: 1}
cloth:
  - {name: patch, mesh: {shape: rectangle, size: [0.1, 0.1], resolution: [3, 3]}, translate: [0, 0, 4]}
obstacles:
  - {name: wave, mesh: {file: ${name}.obj}, motion: {sequence: {cache: ${name}.pc2, fps: 30, loop: pingpong}}}
`,
  );
}

// The folder is made anew; a run is kept where it is whole.
export function makeData() {
  fs.rmSync(work, { recursive: true, force: true });
  fs.mkdirSync(work, { recursive: true });
  fs.writeFileSync(path.join(work, 'watched.yaml'), WATCHED);
  fs.writeFileSync(path.join(work, 'live.yaml'), LIVE);
  fs.writeFileSync(path.join(work, 'long.yaml'), LONG);
  writeLarge('large20', 20000, 60);
  writeLarge('large200', 200000, 16);
  run('run', 'watched.yaml', '-o', 'watched', '--record', 'debug');
  for (const name of ['long', 'large20', 'large200']) run('run', `${name}.yaml`, '-o', name);
}
