// A body as three.js draws it: vertices, normals, colors, and the edges of its triangles.
import * as THREE from 'three';
import { mapValue } from './color.js';

const SHARP = Math.cos((40 * Math.PI) / 180); // edges that bend by more than 40 degrees are drawn as edges

function computeTriangleNormals(body) {
  const normals = new Float32Array(3 * body.triangleCount);
  const [a, b, c, n] = Array.from({ length: 4 }, () => new THREE.Vector3());
  for (let t = 0; t < body.triangleCount; t++) {
    [a, b, c].forEach((corner, k) => corner.set(...[0, 1, 2].map((axis) => body.get(0, body.triangles[3 * t + k], axis))));
    n.crossVectors(b.sub(a), c.sub(a)).normalize().toArray(normals, 3 * t);
  }
  return normals;
}

// For each corner of a triangle the drawn vertex, and for each drawn vertex the body's vertex. Corners of a vertex are one
// drawn vertex where a chain of triangles leads from one to the other over edges that are not sharp. A cloth has no sharp edges.
function splitVertices(body) {
  if (body.kind === 'cloth')
    return { index: body.triangles, source: Uint32Array.from({ length: body.vertexCount }, (_, i) => i) };
  const corners = body.triangles, normals = computeTriangleNormals(body);
  const parent = Uint32Array.from({ length: corners.length }, (_, i) => i);
  const find = (i) => {
    while (parent[i] !== i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const first = new Map(); // edge -> the corner at which it begins in the first triangle that has it
  for (let i = 0; i < corners.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1;
    const low = Math.min(corners[i], corners[next]), high = Math.max(corners[i], corners[next]);
    const edge = low * body.vertexCount + high;
    if (!first.has(edge)) {
      first.set(edge, i);
      continue;
    }
    const other = first.get(edge), otherNext = other % 3 === 2 ? other - 2 : other + 1;
    const t = 3 * Math.floor(i / 3), u = 3 * Math.floor(other / 3);
    if (normals[t] * normals[u] + normals[t + 1] * normals[u + 1] + normals[t + 2] * normals[u + 2] < SHARP) continue;
    const isOpposite = corners[i] === corners[otherNext];
    parent[find(i)] = find(isOpposite ? otherNext : other);
    parent[find(next)] = find(isOpposite ? other : otherNext);
  }
  const number = new Map(), source = [];
  const index = corners.map((vertex, i) => {
    const root = find(i);
    if (!number.has(root)) number.set(root, source.push(vertex) - 1);
    return number.get(root);
  });
  return { index, source: Uint32Array.from(source) };
}

function findEdges(index, vertexCount) {
  const seen = new Set(), edges = [];
  for (let i = 0; i < index.length; i++) {
    const next = i % 3 === 2 ? i - 2 : i + 1;
    const low = Math.min(index[i], index[next]), high = Math.max(index[i], index[next]);
    if (seen.has(low * vertexCount + high)) continue;
    seen.add(low * vertexCount + high);
    edges.push(low, high);
  }
  return edges;
}

// The back is a little darker, so that folds tell their sides apart.
function darkenBack(shader) {
  shader.fragmentShader = shader.fragmentShader.replace(
    '#include <color_fragment>', '#include <color_fragment>\nif (!gl_FrontFacing) diffuseColor.rgb *= 0.72;');
}

export class Surface {
  constructor(body, color, scale) {
    this.body = body;
    this.scale = scale;
    const { index, source } = splitVertices(body);
    this.index = index;
    this.source = source;
    const geometry = new THREE.BufferGeometry();
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    for (const name of ['position', 'normal', ...(body.values ? ['color'] : [])])
      geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * source.length), 3));
    const material = new THREE.MeshStandardMaterial({
      color: body.values ? 0xffffff : new THREE.Color(...color), vertexColors: Boolean(body.values), side: THREE.DoubleSide,
      roughness: 0.85, metalness: 0, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
    });
    material.onBeforeCompile = darkenBack;
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.edges = null;
    this.frame = -1;
  }

  setEdges(isShown) {
    if (isShown && !this.edges) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', this.mesh.geometry.getAttribute('position'));
      geometry.setIndex(findEdges(this.index, this.source.length));
      this.edges = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: 0x1b2430, transparent: true, opacity: 0.55 }));
      this.edges.frustumCulled = false;
      this.mesh.add(this.edges);
    }
    if (this.edges) this.edges.visible = isShown;
  }

  setFrame(frame) {
    this.mesh.visible = this.body.isPresent(frame);
    if (this.frame === frame || (this.frame >= 0 && this.body.frameCount === 1)) return;
    this.frame = frame;
    const { body, source } = this;
    const positions = this.mesh.geometry.getAttribute('position'), colors = this.mesh.geometry.getAttribute('color');
    for (let i = 0; i < source.length; i++)
      for (let axis = 0; axis < 3; axis++) positions.array[3 * i + axis] = body.get(frame, source[i], axis);
    positions.needsUpdate = true;
    this.updateNormals(positions.array);
    if (!colors) return;
    for (let i = 0; i < source.length; i++) colors.array.set(mapValue(this.scale.map, body.getValue(frame, source[i])), 3 * i);
    colors.needsUpdate = true;
  }

  // Means of the triangles around, weighted by their areas.
  updateNormals(x) {
    const attribute = this.mesh.geometry.getAttribute('normal'), n = attribute.array.fill(0), index = this.index;
    for (let i = 0; i < index.length; i += 3) {
      const a = 3 * index[i], b = 3 * index[i + 1], c = 3 * index[i + 2];
      const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
      const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
      const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
      for (const k of [a, b, c]) {
        n[k] += nx;
        n[k + 1] += ny;
        n[k + 2] += nz;
      }
    }
    for (let i = 0; i < n.length; i += 3) {
      const length = Math.hypot(n[i], n[i + 1], n[i + 2]) || 1;
      n[i] /= length;
      n[i + 1] /= length;
      n[i + 2] /= length;
    }
    attribute.needsUpdate = true;
  }

  // Lets go of what a renderer holds of it; another one takes it up again.
  release() {
    for (const part of [this.mesh, this.edges]) {
      part?.geometry.dispose();
      part?.material.dispose();
    }
  }
}
