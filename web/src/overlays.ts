// What is drawn on the surfaces, and the legends: contacts, normals, impulses, patches, gaps, strains, velocities, crossing pairs.
// Kinds differ in shape, hatching or words as well as in color.
import * as THREE from 'three';
import { type ColorMap, fromOklch, mapValue, toCss } from './color.ts';
import { make, write } from './dom.ts';
import { CONTACT, getCrossing, type OverlayMessage } from './protocol.ts';
import type { Stage } from './stage.ts';
import type { Painting, Surface } from './surface.ts';

export interface OverlayKind {
  key: string; // in links
  label: string;
  source: string; // the server's overlay
  part?: number; // of strain: warp, weft, shear
  paints: boolean; // colors surfaces; one of these at a time
}

export const OVERLAYS: readonly OverlayKind[] = [
  { key: 'contacts', label: 'Contacts', source: 'contacts', paints: false },
  { key: 'normals', label: 'Contact normals', source: 'contacts', paints: false },
  { key: 'impulses', label: 'Impulses', source: 'contacts', paints: false },
  { key: 'velocities', label: 'Velocities', source: 'velocities', paints: false },
  { key: 'crossings', label: 'Crossing pairs', source: 'crossings', paints: false },
  { key: 'patches', label: 'Patches', source: 'patches', paints: true },
  { key: 'gaps', label: 'Gaps', source: 'gaps', paints: true },
  { key: 'warp', label: 'Strain along warp', source: 'strain', part: 0, paints: true },
  { key: 'weft', label: 'Strain along weft', source: 'strain', part: 1, paints: true },
  { key: 'shear', label: 'Shear strain', source: 'strain', part: 2, paints: true },
];

const STICK = new THREE.Color(...fromOklch([0.55, 0.17, 255])),
  SLIP = new THREE.Color(...fromOklch([0.72, 0.18, 55]));
const OPEN = new THREE.Color(...fromOklch([0.6, 0.02, 250])),
  ARROW = new THREE.Color(...fromOklch([0.62, 0.24, 310]));
const SPEED = new THREE.Color(...fromOklch([0.58, 0.15, 155])),
  CROSSING = new THREE.Color(...fromOklch([0.58, 0.24, 27]));
const LARGEST_COUNT = 20000; // arrows of velocities that are drawn
const LUT = 256;

function makeTable(map: ColorMap): Uint16Array {
  const table = new Uint16Array(4 * LUT);
  for (let k = 0; k < LUT; k++) {
    const color = mapValue(map, k / (LUT - 1));
    for (let c = 0; c < 3; c++) table[4 * k + c] = Math.round(65535 * color[c]);
    table[4 * k + 3] = map === 'diverging' && k < 0.47 * LUT ? 0 : 65535; // below zero is hatched
  }
  return table;
}

const TABLES = { sequential: makeTable('sequential'), diverging: makeTable('diverging') };

// Points that tell kinds apart by shape: 0 a disc, 1 a diamond, 2 a ring.
function makePoints(): THREE.Points<THREE.BufferGeometry, THREE.ShaderMaterial> {
  const material = new THREE.ShaderMaterial({
    depthTest: true,
    transparent: true,
    uniforms: { size: { value: 11 * Math.min(window.devicePixelRatio, 2) } },
    vertexShader: `attribute vec3 color; attribute float shape; varying vec3 tint; varying float kind; uniform float size;
      void main() {
        tint = color; kind = shape;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
        gl_Position.z -= 0.002 * gl_Position.w; // before the surface that it lies on
        gl_PointSize = kind > 1.5 ? 0.6 * size : size; // open contacts are many, and of less interest
      }`,
    fragmentShader: `varying vec3 tint; varying float kind;
      void main() {
        vec2 at = 2.0 * gl_PointCoord - 1.0;
        float away = kind < 0.5 ? length(at) : kind < 1.5 ? abs(at.x) + abs(at.y) : length(at);
        if (away > 1.0 || (kind > 1.5 && away < 0.5)) discard;
        gl_FragColor = vec4(away > 0.78 && kind < 1.5 ? vec3(1.0) : tint, kind > 1.5 ? 0.7 : 1.0);
        #include <colorspace_fragment>
      }`,
  });
  const points = new THREE.Points(new THREE.BufferGeometry(), material);
  points.frustumCulled = false;
  return points;
}

// Arrows as lines: a shaft and two barbs. The arrays grow and are used again.
class Arrows {
  readonly lines: THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial>;
  private numbers = new Float32Array(0);
  private length = 0;

  constructor(color: THREE.Color) {
    this.lines = new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color }));
    this.lines.frustumCulled = false;
  }

  begin(count: number): void {
    this.length = 0;
    if (this.numbers.length >= 18 * count) return;
    this.numbers = new Float32Array(18 * Math.ceil(1.5 * count));
    this.lines.geometry.dispose();
    this.lines.geometry = new THREE.BufferGeometry();
    this.lines.geometry.setAttribute('position', new THREE.BufferAttribute(this.numbers, 3).setUsage(THREE.DynamicDrawUsage));
  }

  add(from: THREE.Vector3, way: THREE.Vector3, side: THREE.Vector3): void {
    const tip = from.clone().add(way),
      back = from.clone().addScaledVector(way, 0.78),
      barb = 0.12 * way.length();
    const aside = new THREE.Vector3().crossVectors(way, side).normalize().multiplyScalar(barb);
    for (const point of [from, tip, tip, back.clone().add(aside), tip, back.sub(aside)]) {
      point.toArray(this.numbers, this.length);
      this.length += 3;
    }
  }

  end(): void {
    const attribute = this.lines.geometry.getAttribute('position') as THREE.BufferAttribute | undefined;
    if (attribute) attribute.needsUpdate = true;
    this.lines.geometry.setDrawRange(0, this.length / 3);
    this.lines.visible = this.length > 0;
  }
}

interface Scale {
  title: string;
  low: number;
  high: number;
  map: ColorMap;
  note?: string;
}

export class Overlays {
  readonly active = new Set<string>();
  readonly legends = make('div', { class: 'legends', role: 'region', 'aria-label': 'Legends' });
  onChange: () => void = () => {};
  private readonly stage: Stage;
  private readonly points = makePoints();
  private readonly normals = new Arrows(STICK.clone().multiplyScalar(0.6));
  private readonly impulses = new Arrows(ARROW);
  private readonly speeds = new Arrows(SPEED);
  private readonly crossings = makeCrossings();
  private readonly limits = new Map<string, number>(); // the largest value so far, so that colors do not flicker
  private shown: ReadonlyMap<string, OverlayMessage> = new Map();
  private lastText: string | null = null; // of the legends; null: to be written anew

  constructor(stage: Stage) {
    this.stage = stage;
    stage.marks.add(this.points, this.normals.lines, this.impulses.lines, this.speeds.lines, this.crossings);
    this.show(new Map());
  }

  // The server's overlays that are needed.
  get sources(): string[] {
    return [...new Set(OVERLAYS.filter(({ key }) => this.active.has(key)).map(({ source }) => source))];
  }

  toggle(key: string, isOn: boolean): void {
    const kind = OVERLAYS.find((each) => each.key === key);
    if (!kind) return;
    if (isOn && kind.paints) for (const other of OVERLAYS) if (other.paints) this.active.delete(other.key);
    if (isOn) this.active.add(key);
    else this.active.delete(key);
    this.lastText = null;
    this.show(this.shown);
    this.onChange();
  }

  setActive(keys: Iterable<string>): void {
    this.active.clear();
    for (const key of keys) if (OVERLAYS.some((each) => each.key === key)) this.active.add(key);
    this.lastText = null;
    this.show(this.shown);
    this.onChange();
  }

  // Draws the overlays of a frame; those that are not there are left out.
  show(messages: ReadonlyMap<string, OverlayMessage>): void {
    this.shown = messages;
    const legends: (HTMLElement | null)[] = [];
    const contacts = messages.get('contacts');
    legends.push(this.showContacts(contacts));
    legends.push(this.showArrows(contacts));
    legends.push(this.showSpeeds(messages.get('velocities')));
    legends.push(this.showCrossings(messages.get('crossings')));
    legends.push(this.paint(messages));
    this.setLegends(legends.filter((legend) => legend !== null));
    this.stage.ask();
  }

  private setLegends(legends: HTMLElement[]): void {
    const text = legends.map((legend) => legend.outerHTML).join('');
    if (text === this.lastText) return;
    this.lastText = text;
    this.legends.replaceChildren(...legends);
    this.legends.hidden = legends.length === 0;
  }

  private showContacts(message: OverlayMessage | undefined): HTMLElement | null {
    this.points.visible = this.active.has('contacts') && message !== undefined && message.count > 0;
    if (!this.active.has('contacts')) return null;
    const counts = { stick: 0, slip: 0, open: 0, self: 0 };
    if (message) {
      const positions = new Float32Array(3 * message.count),
        colors = new Float32Array(3 * message.count);
      const shapes = new Float32Array(message.count);
      for (let k = 0; k < message.count; k++) {
        const at = CONTACT.words * k,
          flags = message.words[at + CONTACT.flags];
        const kind = flags & CONTACT.stick ? 'stick' : flags & CONTACT.slip ? 'slip' : 'open';
        counts[kind]++;
        if (flags & CONTACT.self) counts.self++;
        positions.set(message.floats.subarray(at, at + 3), 3 * k);
        (kind === 'stick' ? STICK : kind === 'slip' ? SLIP : OPEN).toArray(colors, 3 * k);
        shapes[k] = kind === 'stick' ? 0 : kind === 'slip' ? 1 : 2;
      }
      const { geometry } = this.points;
      geometry.dispose();
      geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
      geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
      geometry.setAttribute('shape', new THREE.BufferAttribute(shapes, 1));
    }
    const row = (shape: string, color: THREE.Color, text: string) => {
      const icon = make('span', { class: `shape ${shape}`, 'aria-hidden': 'true' });
      icon.style.setProperty('--tint', toCss([color.r, color.g, color.b]));
      return make('li', {}, icon, text);
    };
    return make(
      'section',
      { 'aria-label': 'Contacts' },
      make('h2', {}, 'Contacts'),
      make(
        'ul',
        {},
        row('disc', STICK, `${counts.stick} stick`),
        row('diamond', SLIP, `${counts.slip} slip`),
        ...(counts.open ? [row('ring', OPEN, `${counts.open} open`)] : []),
        make('li', {}, `${counts.self} of cloth with itself`),
      ),
    );
  }

  private showArrows(message: OverlayMessage | undefined): HTMLElement | null {
    const hasNormals = this.active.has('normals'),
      hasImpulses = this.active.has('impulses'),
      count = message?.count ?? 0;
    this.normals.begin(hasNormals ? count : 0);
    this.impulses.begin(hasImpulses ? count : 0);
    const size = this.stage.findBox().getSize(new THREE.Vector3()).length() || 1,
      side = this.stage.camera.getAxes()[2];
    let largest = 0;
    const from = new THREE.Vector3(),
      way = new THREE.Vector3();
    if (message && hasImpulses) {
      for (let k = 0; k < count; k++)
        largest = Math.max(largest, way.fromArray(message.floats, CONTACT.words * k + CONTACT.impulse).length());
      largest = this.keepLimit('impulses', largest);
    }
    for (let k = 0; message && k < count; k++) {
      const at = CONTACT.words * k;
      from.fromArray(message.floats, at);
      if (hasNormals)
        this.normals.add(from, way.fromArray(message.floats, at + CONTACT.normal).multiplyScalar(0.025 * size), side);
      if (!hasImpulses || largest === 0) continue;
      way.fromArray(message.floats, at + CONTACT.impulse).multiplyScalar((0.12 * size) / largest);
      if (way.length() > 1e-4 * size) this.impulses.add(from, way, side);
    }
    this.normals.end();
    this.impulses.end();
    if (!hasImpulses && !hasNormals) return null;
    return make(
      'section',
      { 'aria-label': 'Arrows of contacts' },
      ...(hasNormals ? [make('p', {}, 'Short dark arrows: contact normals')] : []),
      ...(hasImpulses ? [make('p', {}, `Purple arrows: impulses, the longest ${write(largest)} N s`)] : []),
    );
  }

  private showSpeeds(message: OverlayMessage | undefined): HTMLElement | null {
    const isOn = this.active.has('velocities');
    if (!isOn || !message) {
      this.speeds.begin(0);
      this.speeds.end();
      return isOn ? make('section', {}, make('h2', {}, 'Velocities'), make('p', {}, 'not yet here')) : null;
    }
    let count = 0,
      largest = 0;
    const way = new THREE.Vector3(),
      from = new THREE.Vector3(),
      side = this.stage.camera.getAxes()[2];
    for (const array of message.byObject.values()) {
      count += array.length / 3;
      for (let i = 0; i < array.length; i += 3) largest = Math.max(largest, Math.hypot(array[i], array[i + 1], array[i + 2]));
    }
    const stride = Math.ceil(count / LARGEST_COUNT),
      size = this.stage.findBox().getSize(way).length() || 1;
    const scale = this.keepLimit('velocities', largest);
    this.speeds.begin(Math.ceil(count / stride) + message.byObject.size);
    for (const [object, array] of message.byObject) {
      const surface = this.stage.surfaces[object];
      if (!surface?.group.visible) continue;
      for (let i = 0; i < array.length / 3 && i < surface.mesh.vertexCount; i += stride) {
        way.fromArray(array, 3 * i).multiplyScalar((0.1 * size) / (scale || 1));
        if (way.length() > 1e-3 * size) this.speeds.add(surface.getVertex(i, from), way, side);
      }
    }
    this.speeds.end();
    return make(
      'section',
      { 'aria-label': 'Velocities' },
      make('h2', {}, 'Velocities'),
      make('p', {}, `Green arrows; the fastest vertex ${write(largest)} m/s`),
      ...(stride > 1 ? [make('p', {}, `every ${stride}th vertex has one`)] : []),
    );
  }

  private showCrossings(message: OverlayMessage | undefined): HTMLElement | null {
    const isOn = this.active.has('crossings'),
      count = message?.count ?? 0;
    this.crossings.visible = isOn && count > 0;
    if (!isOn) return null;
    if (message && count) {
      const numbers: number[] = [],
        point = new THREE.Vector3();
      for (let k = 0; k < count; k++) {
        const { objects, triangles } = getCrossing(message, k);
        for (let side = 0; side < 2; side++) {
          const surface = this.stage.surfaces[objects[side]];
          if (!surface || triangles[side] >= surface.mesh.triangleCount) continue;
          for (const corner of [0, 1, 1, 2, 2, 0])
            numbers.push(...surface.getVertex(surface.mesh.corners[3 * triangles[side] + corner], point).toArray());
        }
      }
      this.crossings.geometry.dispose();
      this.crossings.geometry.setAttribute('position', new THREE.Float32BufferAttribute(numbers, 3));
    }
    const words =
      message === undefined ? 'The judge is at work' : count === 0 ? 'The judge finds none' : `${count} pairs, outlined in red`;
    return make('section', { 'aria-label': 'Crossing pairs' }, make('h2', {}, 'Crossing pairs'), make('p', {}, words));
  }

  private keepLimit(key: string, value: number): number {
    const limit = Math.max(this.limits.get(key) ?? 0, value);
    this.limits.set(key, limit);
    return limit;
  }

  // Colors the surfaces.
  private paint(messages: ReadonlyMap<string, OverlayMessage>): HTMLElement | null {
    const kind = OVERLAYS.find(({ key, paints }) => paints && this.active.has(key)),
      message = kind && messages.get(kind.source);
    if (!kind || !message) {
      for (const surface of this.stage.surfaces) surface.setPainting(null);
      return kind ? make('section', {}, make('h2', {}, kind.label), make('p', {}, 'not yet here')) : null;
    }
    if (kind.key === 'patches') return this.paintPatches(message);
    return kind.key === 'gaps' ? this.paintGaps(message) : this.paintStrain(message, kind);
  }

  private paintPatches(message: OverlayMessage): HTMLElement {
    const labels = new Set<number>();
    for (const [object, surface] of this.stage.surfaces.entries()) {
      const array = message.byObject.get(object);
      if (!array) {
        surface.setPainting(null);
        continue;
      }
      const colors = new Uint16Array(4 * array.length),
        count = Math.min(array.length, surface.mesh.triangleCount);
      for (let t = 0; t < count; t++) {
        const label = array[t],
          isNone = label === 0;
        if (!isNone) labels.add(label);
        // Neighbouring labels get far hues; every other one is hatched.
        const color = isNone ? [0.6, 0.6, 0.6] : fromOklch([0.68 + 0.12 * ((label % 3) - 1), 0.12, (label * 137.5) % 360]);
        for (let c = 0; c < 3; c++) colors[4 * t + c] = Math.round(65535 * color[c]);
        colors[4 * t + 3] = !isNone && label % 2 ? 0 : 65535;
      }
      surface.setPainting({ by: 'triangle', colors });
    }
    return make(
      'section',
      { 'aria-label': 'Patches' },
      make('h2', {}, 'Patches'),
      make('p', {}, `${labels.size} patches, a color each, every other one hatched; grey: in none`),
    );
  }

  private paintGaps(message: OverlayMessage): HTMLElement {
    let least = Infinity,
      largest = 0;
    for (const array of message.byObject.values())
      for (const gap of array)
        if (Number.isFinite(gap)) {
          least = Math.min(least, gap);
          largest = Math.max(largest, gap);
        }
    const high = this.keepLimit('gaps', largest) || 1;
    for (const [object, surface] of this.stage.surfaces.entries()) {
      const array = message.byObject.get(object);
      if (!array) {
        surface.setPainting(null);
        continue;
      }
      const colors = new Uint16Array(4 * surface.mesh.vertexCount);
      for (let i = 0; i < surface.mesh.vertexCount; i++) {
        if (Number.isFinite(array[i])) copyColor(TABLES.sequential, array[i] / high, colors, i);
        else (colors.fill(40000, 4 * i, 4 * i + 3), (colors[4 * i + 3] = 0));
      }
      surface.setPainting({ by: 'vertex', colors });
    }
    const note = `${Number.isFinite(least) ? `the smallest ${write(least * 1000)} mm; ` : ''}grey and hatched: nothing near`;
    return makeScale({ title: 'Gap [mm]', low: 0, high: high * 1000, map: 'sequential', note });
  }

  private paintStrain(message: OverlayMessage, kind: OverlayKind): HTMLElement {
    let largest = 0,
      worst = 0;
    for (const array of message.byObject.values())
      for (let i = kind.part!; i < array.length; i += 3) {
        const value = array[i];
        if (Math.abs(value) > largest) {
          largest = Math.abs(value);
          worst = value;
        }
      }
    const high = this.keepLimit(kind.key, largest) || 1;
    for (const [object, surface] of this.stage.surfaces.entries()) {
      const array = message.byObject.get(object),
        colors = new Uint16Array(4 * surface.mesh.triangleCount);
      if (!array) {
        surface.setPainting(null);
        continue;
      }
      for (let t = 0; t < surface.mesh.triangleCount; t++)
        copyColor(TABLES.diverging, 0.5 + (0.5 * (array[3 * t + kind.part!] || 0)) / high, colors, t);
      surface.setPainting({ by: 'triangle', colors });
    }
    return makeScale({
      title: `${kind.label} [%]`,
      low: -100 * high,
      high: 100 * high,
      map: 'diverging',
      note: `largest now ${write(100 * worst)} %; hatched: negative`,
    });
  }

  clear(): void {
    this.limits.clear();
    this.show(new Map());
  }

  // The overlay of the frame that is shown, for what tells about it.
  getShown(name: string): OverlayMessage | undefined {
    return this.shown.get(name);
  }
}

function copyColor(table: Uint16Array, value: number, colors: Uint16Array, place: number): void {
  const from = 4 * Math.round(Math.min(Math.max(value, 0), 1) * (LUT - 1));
  for (let c = 0; c < 4; c++) colors[4 * place + c] = table[from + c];
}

function makeCrossings(): THREE.LineSegments<THREE.BufferGeometry, THREE.LineBasicMaterial> {
  const lines = new THREE.LineSegments(
    new THREE.BufferGeometry(),
    new THREE.LineBasicMaterial({ color: CROSSING, depthTest: false }),
  );
  lines.frustumCulled = false;
  lines.renderOrder = 5;
  return lines;
}

function makeScale({ title, low, high, map, note }: Scale): HTMLElement {
  const bar = make('div', { class: `scale ${map}` });
  const stops = Array.from({ length: 17 }, (_, k) => toCss(mapValue(map, k / 16))).join(', ');
  bar.style.setProperty('--stops', `linear-gradient(to right, ${stops})`);
  return make(
    'section',
    { 'aria-label': title },
    make('h2', {}, title),
    bar,
    make('div', { class: 'ends' }, make('span', {}, write(low)), make('span', {}, write(high))),
    ...(note ? [make('p', {}, note)] : []),
  );
}

export type { Painting, Surface };
