// Runs a case of bench-peers in MuJoCo's WebAssembly build: node mujoco_driver.mjs MODULES CASE OUTPUT
//
// MODULES is a node_modules folder that holds @mujoco/mujoco; CASE and OUTPUT are as run.py says. The cloth is a flex of dimension 2
// with Tulle's vertices and triangles. What lies in the plane z = 0 becomes a plane and what is a sphere up to a thousandth a sphere,
// as its users would have it; any other obstacle is a mesh, of which MuJoCo takes the convex hull.
import fs from 'node:fs';
import path from 'node:path';

const [modules, casePath, output] = process.argv.slice(2);

function readCase() {
  const read = { obstacle: [], set: {} };
  for (const line of fs.readFileSync(casePath, 'utf8').split('\n').filter(Boolean)) {
    const [key, ...values] = line.split(' ');
    if (key === 'obstacle') read.obstacle.push({ path: values[0], friction: values[1] });
    else if (key === 'set') read.set[values[0]] = values[1];
    else read[key] = values[0];
  }
  return read;
}

function readMesh(file) {
  const vertices = [], triangles = [];
  for (const line of fs.readFileSync(file, 'utf8').split('\n')) {
    const words = line.split(' ');
    if (words[0] === 'v') vertices.push(words.slice(1, 4).map(Number));
    if (words[0] === 'f') triangles.push(words.slice(1, 4).map((word) => parseInt(word) - 1));
  }
  return { vertices, triangles };
}

function makeGeom({ path: file, friction }, name, assets) {
  const { vertices } = readMesh(file);
  const common = `name="${name}" friction="${friction} 0.005 0.0001" solref="0.01 1" solimp="0.95 0.99 0.0001"`;
  if (vertices.every((vertex) => vertex[2] === 0)) return `<geom ${common} type="plane" size="3 3 0.1"/>`;
  const centre = [0, 1, 2].map((k) => (Math.min(...vertices.map((v) => v[k])) + Math.max(...vertices.map((v) => v[k]))) / 2);
  const radii = vertices.map((v) => Math.hypot(...v.map((x, k) => x - centre[k])));
  const radius = Math.max(...radii);
  if (Math.min(...radii) > 0.999 * radius)
    return `<geom ${common} type="sphere" size="${radius}" pos="${centre.join(' ')}"/>`;
  assets.push(`<mesh name="${name}" inertia="convex" vertex="${vertices.flat().join(' ')}"/>`);
  return `<geom ${common} type="mesh" mesh="${name}"/>`;
}

function makeModel(read) {
  const set = read.set;
  const cloth = readMesh(read.cloth);
  const assets = [];
  const geoms = read.obstacle.map((obstacle, k) => makeGeom(obstacle, `obstacle${k}`, assets));
  return `<mujoco>
  <option timestep="${set.timestep}" solver="${set.solver}" tolerance="${set.tolerance}" iterations="${set.iterations}"
          integrator="${set.integrator}" gravity="0 0 -${read.gravity}"><flag ipc="${set.ipc}"/></option>
  <size memory="${set.memory}"/>
  <asset>${assets.join('\n')}</asset>
  <worldbody>
    ${geoms.join('\n    ')}
    <flexcomp name="cloth" type="direct" dim="2" mass="${read.mass}" radius="${set.radius}"
              point="${cloth.vertices.flat().join(' ')}" element="${cloth.triangles.flat().join(' ')}">
      <contact selfcollide="auto" passive="${set.passive}" friction="${set.self_friction} 0.005 0.0001"
               solref="0.01 1" solimp="0.95 0.99 0.0001"/>
      <elasticity young="${set.young}" poisson="${set.poisson}" thickness="${set.shell_thickness}" elastic2d="both"
                  damping="${set.damping}"/>
    </flexcomp>
  </worldbody>
</mujoco>`;
}

const getCpu = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
};

const read = readCase();
const { default: load } = await import(path.resolve(modules, '@mujoco/mujoco/mujoco.js'));
const printed = new Set();
const told = fs.openSync(`${output}/told.txt`, 'w');
const tell = (text) => fs.writeSync(told, `${text}\n`);
const tellOnce = (text) => {
  const kind = text.replace(/[\d.]+/g, '#'); // warnings come again with other numbers
  if (!printed.has(kind) && text.trim()) tell(`message ${text.trim()}`);
  printed.add(kind);
};
const mujoco = await load({ print: tellOnce, printErr: tellOnce });
tell(`version ${mujoco.mj_versionString()} (WebAssembly, node ${process.versions.node})`);
const text = makeModel(read);
fs.writeFileSync(`${output}/model.xml`, text);
const model = mujoco.MjModel.from_xml_string(text);
const data = new mujoco.MjData(model);
mujoco.mj_forward(model, data);

const raw = fs.openSync(`${output}/frames.raw`, 'w');
const writeFrame = (time, cpu) => {
  fs.writeSync(raw, new Uint8Array(Float32Array.from(data.flexvert_xpos).buffer));
  tell(`frame ${time.toFixed(9)} ${cpu.toFixed(3)}`);
};
writeFrame(0, 0);
const start = getCpu();
let frame = 1;
while (frame <= Number(read.frames)) {
  mujoco.mj_step(model, data);
  const cpu = getCpu() - start;
  const isFull = data.time > frame * Number(read.interval) - Number(read.set.timestep) / 2;
  const isOver = cpu > Number(read.limit);
  if (isFull || isOver) {
    mujoco.mj_kinematics(model, data); // a step leaves the vertices where they were before it
    mujoco.mj_flex(model, data);
    writeFrame(data.time, cpu);
    frame++;
  }
  if (isOver) {
    tell(`message stopped at the limit of processor time`);
    break;
  }
}
