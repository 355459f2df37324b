// An object as three.js draws it: vertices, normals, colors of an overlay, and the edges of its triangles.
import * as THREE from 'three';
import { computeNormals, findEdges, splitSharpEdges } from './geometry.ts';
import type { Mesh, ObjectInfo, ObjectState } from './protocol.ts';

export interface Look {
  shading: 'smooth' | 'flat';
  texture: 'plain' | 'checker';
  hasWires: boolean;
  hasShadows: boolean;
}

// Colors of an overlay: four 16-bit numbers each, red, green, blue, and 0 where hatching tells the value, too.
export interface Painting {
  by: 'vertex' | 'triangle';
  colors: Uint16Array;
}

const CELLS = 16; // of a checkered object along its largest side

// The back is a little darker, so that folds tell their sides apart; checks; hatching where the alpha of a color is 0.
function addMarks(material: THREE.MeshStandardMaterial, isCheckered: { value: number }): void {
  material.onBeforeCompile = (shader) => {
    shader.uniforms.isCheckered = isCheckered;
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nattribute vec3 chart;\nvarying vec3 place;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nplace = chart;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', '#include <common>\nuniform float isCheckered;\nvarying vec3 place;')
      .replace(
        '#include <color_fragment>',
        `#include <color_fragment>
        vec3 cell = floor(place);
        if (isCheckered > 0.5 && mod(cell.x + cell.y + cell.z, 2.0) > 0.5) diffuseColor.rgb *= 0.55;
        #ifdef USE_COLOR_ALPHA
          if (vColor.a < 0.5 && fract((gl_FragCoord.x + gl_FragCoord.y) / 8.0) < 0.3) diffuseColor.rgb *= 0.6;
        #endif
        if (!gl_FrontFacing) diffuseColor.rgb *= 0.72;`,
      );
  };
}

// Where a vertex lies on the checks: by its uv, or by its place in the mesh.
function makeChart(mesh: Mesh): Float32Array {
  const chart = new Float32Array(3 * mesh.vertexCount),
    box = new THREE.Box3().setFromArray(mesh.positions);
  const size = Math.max(...box.getSize(new THREE.Vector3()).toArray(), 1e-9),
    low = box.min.toArray();
  for (let i = 0; i < mesh.vertexCount; i++)
    for (let axis = 0; axis < 3; axis++) {
      const place = mesh.uv ? (axis < 2 ? mesh.uv[2 * i + axis] : 0) : (mesh.positions[3 * i + axis] - low[axis]) / size;
      chart[3 * i + axis] = CELLS * place + 0.01;
    }
  return chart;
}

export class Surface {
  readonly mesh: Mesh;
  readonly info: ObjectInfo;
  readonly group = new THREE.Group();
  positions: Float32Array; // as drawn [m]
  isShown = true;
  private readonly index: Uint32Array;
  private readonly source: Uint32Array | null; // the mesh's vertex of each drawn one; null: the same
  private readonly whole: THREE.BufferGeometry; // triangles share vertices
  private apart: THREE.BufferGeometry | null = null; // each triangle has its own vertices
  private readonly body: THREE.Mesh<THREE.BufferGeometry, THREE.MeshStandardMaterial>;
  private edges: THREE.LineSegments | null = null;
  private readonly isCheckered = { value: 0 };
  private readonly color: THREE.Color;
  private look: Look = { shading: 'smooth', texture: 'plain', hasWires: false, hasShadows: true };
  private painting: Painting | null = null;
  private seen: Float32Array | null = null;
  private isStale = true;

  constructor(mesh: Mesh, info: ObjectInfo, color: readonly [number, number, number]) {
    this.mesh = mesh;
    this.info = info;
    this.positions = mesh.positions;
    const split = info.role === 'cloth' ? { index: mesh.corners, source: null } : splitSharpEdges(mesh.positions, mesh.corners);
    this.index = split.index;
    this.source = split.source;
    const count = this.source?.length ?? mesh.vertexCount;
    this.whole = new THREE.BufferGeometry();
    this.whole.setIndex(new THREE.BufferAttribute(this.index, 1));
    for (const name of ['position', 'normal'])
      this.whole.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3).setUsage(THREE.DynamicDrawUsage));
    this.whole.setAttribute('chart', new THREE.BufferAttribute(this.gather(makeChart(mesh), 3), 3));
    this.color = new THREE.Color(...color);
    const material = new THREE.MeshStandardMaterial({
      color: this.color,
      side: THREE.DoubleSide,
      roughness: 0.85,
      metalness: 0,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
    addMarks(material, this.isCheckered);
    this.body = new THREE.Mesh(this.whole, material);
    this.body.castShadow = this.body.receiveShadow = true;
    this.body.frustumCulled = false;
    this.group.add(this.body);
  }

  // Numbers of the mesh's vertices for the drawn ones.
  private gather<T extends Float32Array | Uint16Array>(values: T, width: number): T {
    const { source } = this;
    if (!source) return values;
    const out = new (values.constructor as new (length: number) => T)(width * source.length);
    for (let i = 0; i < source.length; i++) for (let k = 0; k < width; k++) out[width * i + k] = values[width * source[i] + k];
    return out;
  }

  // `positions` null: as the mesh.
  setState(positions: Float32Array | null, isAbsent: boolean): void {
    this.group.visible = this.isShown && !isAbsent;
    this.positions = positions ?? this.mesh.positions;
    // A new array may hold other numbers in the same place, so only the mesh's own is known to be the same.
    if (positions || this.seen !== this.positions) this.isStale = true;
  }

  setObject(state: ObjectState): void {
    this.setState(state.hasMoved ? state.positions : null, state.isAbsent);
  }

  setLook(look: Look): void {
    const { material } = this.body;
    if (look.shading !== this.look.shading) {
      material.flatShading = look.shading === 'flat';
      material.needsUpdate = true;
      this.isStale = true;
    }
    this.look = { ...look };
    this.isCheckered.value = Number(look.texture === 'checker');
    this.body.castShadow = this.body.receiveShadow = look.hasShadows;
    if (look.hasWires && !this.edges) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute('position', this.whole.getAttribute('position'));
      geometry.setIndex(new THREE.BufferAttribute(findEdges(this.index, this.source?.length ?? this.mesh.vertexCount), 1));
      this.edges = new THREE.LineSegments(
        geometry,
        new THREE.LineBasicMaterial({ color: 0x10161e, transparent: true, opacity: 0.5 }),
      );
      this.edges.frustumCulled = false;
      this.group.add(this.edges);
    }
    if (this.edges) this.edges.visible = look.hasWires;
  }

  setPainting(painting: Painting | null): void {
    if (painting === this.painting) return;
    const { material } = this.body;
    this.painting = painting;
    this.isStale = true;
    material.vertexColors = painting !== null;
    material.color.copy(painting ? new THREE.Color(1, 1, 1) : this.color);
    const geometry = painting?.by === 'triangle' ? (this.apart ??= this.takeApart()) : this.whole;
    if (painting) this.paint(geometry, painting);
    else geometry.deleteAttribute('color');
    if (this.body.geometry !== geometry) this.body.geometry = geometry;
    material.needsUpdate = true;
  }

  private paint(geometry: THREE.BufferGeometry, { by, colors }: Painting): void {
    const corners = this.mesh.corners.length;
    const length = by === 'triangle' ? 4 * corners : 4 * (this.source?.length ?? this.mesh.vertexCount);
    let attribute = geometry.getAttribute('color') as THREE.BufferAttribute | undefined;
    if (!attribute) {
      attribute = new THREE.BufferAttribute(new Uint16Array(length), 4, true).setUsage(THREE.DynamicDrawUsage);
      geometry.setAttribute('color', attribute);
    }
    if (by === 'vertex') attribute.array.set(this.gather(colors, 4));
    else
      for (let i = 0; i < corners; i++) {
        const from = 4 * Math.floor(i / 3);
        for (let k = 0; k < 4; k++) attribute.array[4 * i + k] = colors[from + k];
      }
    attribute.needsUpdate = true;
  }

  private takeApart(): THREE.BufferGeometry {
    const geometry = new THREE.BufferGeometry(),
      count = this.index.length;
    for (const name of ['position', 'normal', 'chart'])
      geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * count), 3).setUsage(THREE.DynamicDrawUsage));
    this.spread(geometry, 'chart');
    return geometry;
  }

  private spread(geometry: THREE.BufferGeometry, name: string): void {
    const to = geometry.getAttribute(name) as THREE.BufferAttribute,
      from = this.whole.getAttribute(name).array,
      { index } = this;
    for (let i = 0; i < index.length; i++) {
      const k = 3 * index[i];
      to.array[3 * i] = from[k];
      to.array[3 * i + 1] = from[k + 1];
      to.array[3 * i + 2] = from[k + 2];
    }
    to.needsUpdate = true;
  }

  // Brings what is drawn up to date; called before drawing, so frames that are never drawn cost nothing.
  update(): void {
    if (!this.isStale || !this.group.visible) return;
    this.isStale = false;
    this.seen = this.positions;
    const position = this.whole.getAttribute('position') as THREE.BufferAttribute;
    const normal = this.whole.getAttribute('normal') as THREE.BufferAttribute;
    const { source, positions } = this,
      drawn = position.array as Float32Array;
    if (!source) drawn.set(positions);
    else
      for (let i = 0; i < source.length; i++) {
        const k = 3 * source[i];
        drawn[3 * i] = positions[k];
        drawn[3 * i + 1] = positions[k + 1];
        drawn[3 * i + 2] = positions[k + 2];
      }
    position.needsUpdate = true;
    // Flat shading takes normals from derivatives on the graphics card.
    if (this.look.shading === 'smooth') {
      computeNormals(drawn, this.index, normal.array as Float32Array);
      normal.needsUpdate = true;
    }
    if (this.body.geometry !== this.apart || !this.apart) return;
    this.spread(this.apart, 'position');
    if (this.look.shading === 'smooth') this.spread(this.apart, 'normal');
  }

  // The place of a vertex [m].
  getVertex(index: number, out = new THREE.Vector3()): THREE.Vector3 {
    return out.fromArray(this.positions, 3 * index);
  }

  // A point of a triangle by its barycentric weights.
  getPoint(triangle: number, weights: readonly number[], out = new THREE.Vector3()): THREE.Vector3 {
    const corner = new THREE.Vector3();
    out.set(0, 0, 0);
    for (let k = 0; k < 3; k++) out.addScaledVector(this.getVertex(this.mesh.corners[3 * triangle + k], corner), weights[k]);
    return out;
  }

  // Adds all vertices to a box; in a large mesh some of them are enough to frame it.
  growBox(box: THREE.Box3): void {
    const stride = Math.max(1, Math.floor(this.mesh.vertexCount / 4000)),
      point = new THREE.Vector3();
    for (let i = 0; i < this.mesh.vertexCount; i += stride) box.expandByPoint(this.getVertex(i, point));
  }

  dispose(): void {
    this.whole.dispose();
    this.apart?.dispose();
    this.edges?.geometry.dispose();
    this.body.material.dispose();
    this.group.removeFromParent();
  }
}
