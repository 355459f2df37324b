// What lies under the pointer, and what is chosen: a point of a triangle with its nearest edge and vertex.
import * as THREE from 'three';
import type { Stage } from './stage.ts';
import type { Surface } from './surface.ts';

export interface Hit {
  object: number;
  triangle: number;
  weights: [number, number, number];
  point: THREE.Vector3;
  distance: number;
}

export type Part = 'vertex' | 'edge' | 'triangle';

export interface Selection {
  object: number;
  triangle: number;
  weights: [number, number, number];
  part: Part;
}

const SLACK = 1e-6; // of a weight: a ray along an edge is to miss neither triangle by rounding

// The nearest triangle of a surface on a ray. By T. Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997.
function intersect(surface: Surface, ray: THREE.Ray, best: Hit | null, object: number): Hit | null {
  const { x: ox, y: oy, z: oz } = ray.origin,
    { x: dx, y: dy, z: dz } = ray.direction,
    { corners } = surface.mesh,
    x = surface.positions;
  let found = -1,
    distance = best?.distance ?? Infinity,
    u = 0,
    v = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const a = 3 * corners[i],
      b = 3 * corners[i + 1],
      c = 3 * corners[i + 2];
    const ux = x[b] - x[a],
      uy = x[b + 1] - x[a + 1],
      uz = x[b + 2] - x[a + 2];
    const vx = x[c] - x[a],
      vy = x[c + 1] - x[a + 1],
      vz = x[c + 2] - x[a + 2];
    const px = dy * vz - dz * vy,
      py = dz * vx - dx * vz,
      pz = dx * vy - dy * vx,
      determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const tx = ox - x[a],
      ty = oy - x[a + 1],
      tz = oz - x[a + 2],
      s = (tx * px + ty * py + tz * pz) / determinant;
    if (!(s >= -SLACK && s <= 1 + SLACK)) continue;
    const qx = ty * uz - tz * uy,
      qy = tz * ux - tx * uz,
      qz = tx * uy - ty * ux,
      t = (dx * qx + dy * qy + dz * qz) / determinant;
    if (!(t >= -SLACK && s + t <= 1 + SLACK)) continue;
    const along = (vx * qx + vy * qy + vz * qz) / determinant;
    if (!(along > 0 && along < distance)) continue;
    distance = along;
    found = i / 3;
    u = s;
    v = t;
  }
  if (found < 0) return best;
  const weights = [1 - u - v, u, v].map((weight) => Math.min(Math.max(weight, 0), 1)) as [number, number, number];
  return { object, triangle: found, weights, distance, point: ray.at(distance, new THREE.Vector3()) };
}

export class Picker {
  selection: Selection | null = null;
  onSelect: (selection: Selection | null) => void = () => {};
  private readonly stage: Stage;
  private readonly outline: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private readonly edge: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private readonly dot: THREE.Points<THREE.BufferGeometry, THREE.PointsMaterial>;

  constructor(stage: Stage) {
    this.stage = stage;
    const line = (color: number) => {
      const made = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color, depthTest: false }));
      made.frustumCulled = false;
      made.renderOrder = 8;
      return made;
    };
    this.outline = line(0xffd400);
    this.edge = line(0xff3d7f);
    this.dot = new THREE.Points(
      new THREE.BufferGeometry(),
      new THREE.PointsMaterial({ color: 0xff3d7f, size: 9, sizeAttenuation: false, depthTest: false }),
    );
    this.dot.frustumCulled = false;
    this.dot.renderOrder = 9;
    stage.marks.add(this.outline, this.edge, this.dot);
    this.update();
  }

  getRay(event: { clientX: number; clientY: number }): THREE.Ray {
    const box = this.stage.canvas.getBoundingClientRect(),
      caster = new THREE.Raycaster();
    const place = new THREE.Vector2(
      (2 * (event.clientX - box.left)) / box.width - 1,
      1 - (2 * (event.clientY - box.top)) / box.height,
    );
    this.stage.camera.camera.updateMatrixWorld();
    caster.setFromCamera(place, this.stage.camera.camera);
    return caster.ray;
  }

  find(event: { clientX: number; clientY: number }, accepts: (surface: Surface) => boolean = () => true): Hit | null {
    const ray = this.getRay(event);
    let best: Hit | null = null;
    this.stage.surfaces.forEach((surface, object) => {
      if (surface.group.visible && accepts(surface)) best = intersect(surface, ray, best, object);
    });
    return best;
  }

  select(selection: Selection | null): void {
    const surface = selection && this.stage.surfaces[selection.object];
    this.selection = surface && selection.triangle < surface.mesh.triangleCount ? selection : null;
    this.update();
    this.onSelect(this.selection);
  }

  // Chooses what the pointer is on: a vertex where it is near one, else an edge, else the triangle.
  choose(hit: Hit): void {
    const sorted = [...hit.weights].sort((a, b) => b - a);
    const part: Part = sorted[0] > 0.72 ? 'vertex' : sorted[2] < 0.12 ? 'edge' : 'triangle';
    this.select({ object: hit.object, triangle: hit.triangle, weights: hit.weights, part });
  }

  // A vertex by its number.
  chooseVertex(object: number, vertex: number): boolean {
    const surface = this.stage.surfaces[object];
    if (!surface) return false;
    const corner = surface.mesh.corners.indexOf(vertex);
    if (corner < 0) return false;
    const weights: [number, number, number] = [0, 0, 0];
    weights[corner % 3] = 1;
    this.select({ object, triangle: Math.floor(corner / 3), weights, part: 'vertex' });
    return true;
  }

  getNearest(): { vertex: number; edge: [number, number] } | null {
    const { selection } = this,
      surface = selection && this.stage.surfaces[selection.object];
    if (!selection || !surface) return null;
    const order = [0, 1, 2].sort((a, b) => selection.weights[b] - selection.weights[a]);
    const corner = (k: number) => surface.mesh.corners[3 * selection.triangle + order[k]];
    return { vertex: corner(0), edge: [corner(0), corner(1)] };
  }

  // Moves the marks along with the frame.
  update(): void {
    const { selection } = this,
      surface = selection && this.stage.surfaces[selection.object],
      nearest = this.getNearest();
    const isShown = Boolean(surface?.group.visible && nearest);
    for (const each of [this.outline, this.edge, this.dot]) each.visible = isShown;
    if (isShown && surface && nearest && selection) {
      const corners = [0, 1, 2].map((k) => surface.getVertex(surface.mesh.corners[3 * selection.triangle + k]));
      setLine(
        this.outline,
        [0, 1, 1, 2, 2, 0].map((k) => corners[k]),
      );
      setLine(
        this.edge,
        nearest.edge.map((vertex) => surface.getVertex(vertex)),
      );
      setLine(this.dot, [surface.getVertex(nearest.vertex)]);
      this.edge.visible = selection.part === 'edge';
      this.dot.visible = selection.part === 'vertex';
    }
    this.stage.ask();
  }
}

export function setLine(object: THREE.Object3D & { geometry: THREE.BufferGeometry }, points: readonly THREE.Vector3[]): void {
  let attribute = object.geometry.getAttribute('position') as THREE.BufferAttribute | undefined;
  if (!attribute || attribute.count !== points.length) {
    object.geometry.dispose();
    attribute = new THREE.BufferAttribute(new Float32Array(3 * points.length), 3);
    object.geometry.setAttribute('position', attribute);
  }
  points.forEach((point, k) => point.toArray(attribute.array, 3 * k));
  attribute.needsUpdate = true;
}
