// What the page and the server say to each other: web/PROTOCOL.md. Types of the text messages, and the binary messages taken apart.
//
// A frame may lean on the frame message before it, so a FrameDecoder keeps the state of every object and has to see every message.
// It writes into arrays that it made once: a frame leaves no garbage.

export const SUBPROTOCOL = 'tulle-1';
export const VERSION = 1;

export type Vector = [number, number, number];
export type Role = 'cloth' | 'obstacle' | 'body';

export interface ObjectInfo {
  name: string;
  role: Role;
  vertex_count: number;
  triangle_count: number;
  is_static: boolean;
  has_uv: boolean;
  color?: Vector | null;
  pins?: number;
  thickness?: number;
  material?: string | null;
  friction?: number;
}

// What a scene says of its camera: parts of it.
export interface SceneCamera {
  position?: Vector;
  target?: Vector;
  orbit?: [number, number]; // azimuth, elevation [rad]
  distance?: number;
  field_of_view?: number;
}

export interface Settings {
  gravity?: Vector;
  wind?: Vector;
  gusts?: number;
  materials?: Record<string, string>;
  presets?: string[];
}

export interface DocumentMessage {
  type: 'document';
  version: number;
  program: string;
  kind: 'run' | 'mesh' | 'scene';
  title: string;
  path: string;
  live: boolean;
  up: Vector;
  box: { low: Vector; high: Vector };
  frame_count: number;
  frame_seconds: number;
  step_seconds: number;
  is_under_way: boolean;
  objects: ObjectInfo[];
  overlays: string[];
  series: { name: string; unit: string }[];
  abilities: string[];
  settings?: Settings | null;
  camera?: SceneCamera | null;
  problems?: Problem[];
}

export interface ChangedMessage {
  type: 'changed';
  frame_count: number;
  is_under_way: boolean;
}

export interface StateMessage {
  type: 'state';
  is_running: boolean;
  step: number;
  time: number;
  frame: number;
  steps_per_second: number;
  real_time_ratio: number;
  contacts: number;
  energies: { kinetic: number; gravity: number; elastic: number };
  held: number[];
  message: string;
  saved: number[];
  is_starting?: boolean;
  is_replaying?: boolean;
  has_failed?: boolean;
}

export interface SeriesMessage {
  type: 'series';
  names: string[];
  steps: number[];
  low: Record<string, (number | null)[]>;
  high: Record<string, (number | null)[]>;
}

export interface PickedContact {
  kind: string;
  features?: string;
  object?: number | string;
  gap?: number;
  normal?: Vector;
  impulse?: Vector | number;
}

export interface PickedMessage {
  type: 'picked';
  object: number;
  frame: number;
  position?: Vector;
  vertex?: {
    index: number;
    position?: Vector;
    velocity?: Vector;
    mass?: number;
    is_pinned?: boolean;
    triangles?: number | number[];
  };
  edge?: { vertices?: [number, number]; length?: number; rest_length?: number; strain?: number };
  triangle?: {
    index: number;
    vertices?: Vector;
    area?: number;
    patch?: number;
    strain?: { warp?: number; weft?: number; shear?: number };
  };
  contacts?: PickedContact[];
}

export interface Problem {
  line: number;
  column: number;
  message: string;
}

export interface SchemaKey {
  path: string;
  kind?: string;
  unit?: string | null;
  choices?: string[] | null;
  default?: string | null;
  help?: string;
}

// ---- binary messages ----

export const HEADER_BYTES = 24;
export const KIND = { mesh: 1, frame: 2, overlay: 3 } as const;
export const OVERLAY_NUMBERS: Record<string, number> = {
  contacts: 1,
  velocities: 2,
  patches: 3,
  strain: 4,
  gaps: 5,
  crossings: 6,
};
const OVERLAY_NAMES = Object.fromEntries(Object.entries(OVERLAY_NUMBERS).map(([name, number]) => [number, name]));

export interface Header {
  kind: number;
  object: number; // of an overlay: its number
  frame: number;
  time: number;
  sequence: number;
  count: number;
}

export function readHeader(buffer: ArrayBuffer): Header {
  if (buffer.byteLength < HEADER_BYTES) throw new Error('a message is shorter than its header');
  const view = new DataView(buffer);
  if (view.getUint8(1) !== VERSION) throw new Error(`a message has version ${view.getUint8(1)}; the page speaks ${VERSION}`);
  return {
    kind: view.getUint8(0),
    object: view.getUint16(2, true),
    frame: view.getUint32(4, true),
    time: view.getFloat64(8, true),
    sequence: view.getUint32(16, true),
    count: view.getUint32(20, true),
  };
}

export interface Mesh {
  object: number;
  vertexCount: number;
  triangleCount: number;
  positions: Float32Array; // 3 a vertex [m]
  corners: Uint32Array; // 3 a triangle
  uv: Float32Array | null; // 2 a vertex
}

export function readMesh(buffer: ArrayBuffer): Mesh {
  const { object } = readHeader(buffer),
    view = new DataView(buffer);
  const vertexCount = view.getUint32(24, true),
    triangleCount = view.getUint32(28, true),
    hasUv = (view.getUint32(32, true) & 1) !== 0;
  let place = 36;
  const positions = new Float32Array(buffer, place, 3 * vertexCount);
  place += positions.byteLength;
  const corners = new Uint32Array(buffer, place, 3 * triangleCount);
  place += corners.byteLength;
  const uv = hasUv ? new Float32Array(buffer, place, 2 * vertexCount) : null;
  for (const corner of corners) if (corner >= vertexCount) throw new Error('a triangle has a vertex that is not there');
  return { object, vertexCount, triangleCount, positions, corners, uv };
}

const CODING = { unchanged: 0, exact: 1, key: 2, delta: 3 } as const;
const BLOCK = 64; // vertices of a block of differences

// An object as the last frame message left it.
export class ObjectState {
  readonly positions: Float32Array; // 3 a vertex [m]
  isAbsent = false;
  hasMoved = false; // positions are no longer those of the mesh
  revision = 0; // grows with every change
  private steps: Uint16Array | null = null;
  private readonly low = new Float64Array(3);
  private step = 0;

  constructor(mesh: Mesh) {
    this.positions = mesh.positions.slice();
  }

  // Reads what follows the object's head at `place`; returns where it ends.
  read(buffer: ArrayBuffer, place: number, coding: number): number {
    const length = this.positions.length;
    if (coding === CODING.unchanged) return place;
    this.revision++;
    this.hasMoved = true;
    if (coding === CODING.exact) {
      this.positions.set(new Float32Array(buffer, place, length));
      return place + 4 * length;
    }
    if (coding === CODING.key) {
      const head = new Float32Array(buffer, place, 4);
      this.low.set(head.subarray(0, 3));
      this.step = head[3];
      this.steps ??= new Uint16Array(length);
      this.steps.set(new Uint16Array(buffer, place + 16, length));
      this.place(0, length);
      return place + 16 + 2 * length;
    }
    if (coding === CODING.delta) return this.readDifferences(new Uint8Array(buffer), place);
    throw new Error(`a frame has coding ${coding}`);
  }

  private readDifferences(bytes: Uint8Array, start: number): number {
    const steps = this.steps;
    if (!steps) throw new Error('a frame of differences comes before a whole one');
    let place = start;
    for (let first = 0; first < steps.length; first += 3 * BLOCK) {
      const end = Math.min(first + 3 * BLOCK, steps.length),
        width = bytes[place++];
      if (width === 0) continue;
      if (width > 2 || place + width * (end - first) > bytes.length) throw new Error('a frame of differences is damaged');
      if (width === 1) for (let i = first; i < end; i++) steps[i] += (bytes[place++] << 24) >> 24;
      else for (let i = first; i < end; i++, place += 2) steps[i] = bytes[place] | (bytes[place + 1] << 8);
      this.place(first, end);
    }
    if (place > bytes.length) throw new Error('a frame of differences is damaged');
    return place;
  }

  // Steps to metres. Numbers first .. end - 1; first is that of an x.
  private place(first: number, end: number): void {
    const { positions, step } = this,
      steps = this.steps!,
      [x, y, z] = this.low;
    for (let i = first; i < end; i += 3) {
      positions[i] = x + step * steps[i];
      positions[i + 1] = y + step * steps[i + 1];
      positions[i + 2] = z + step * steps[i + 2];
    }
  }
}

export class FrameDecoder {
  readonly objects: ObjectState[];

  constructor(meshes: readonly Mesh[]) {
    this.objects = meshes.map((mesh) => new ObjectState(mesh));
  }

  // Takes a frame message into the objects.
  read(buffer: ArrayBuffer): Header {
    const header = readHeader(buffer),
      view = new DataView(buffer);
    let place = HEADER_BYTES;
    for (let k = 0; k < header.count; k++) {
      const state = this.objects[view.getUint16(place, true)];
      if (!state || view.getUint32(place + 4, true) * 3 !== state.positions.length)
        throw new Error('a frame does not fit its mesh');
      const isAbsent = (view.getUint8(place + 3) & 1) !== 0;
      if (isAbsent !== state.isAbsent) state.revision++;
      state.isAbsent = isAbsent;
      place = state.read(buffer, place + 8, view.getUint8(place + 2));
      place = (place + 3) & ~3;
    }
    return header;
  }
}

// ---- overlays ----

export const CONTACT = { words: 11, normal: 3, impulse: 6, gap: 9, flags: 10, stick: 1, slip: 2, self: 4 } as const;

export interface OverlayMessage {
  name: string;
  frame: number;
  count: number; // contacts, crossings, or objects
  floats: Float32Array; // the whole of it, as floats and as words: contacts, CONTACT.words each; crossings, 3 words each
  words: Uint32Array;
  byObject: Map<number, Float32Array | Uint32Array>; // of velocities, patches, strain, gaps
}

export function readOverlay(buffer: ArrayBuffer): OverlayMessage {
  const header = readHeader(buffer),
    name = OVERLAY_NAMES[header.object & 255],
    view = new DataView(buffer);
  if (!name) throw new Error(`there is no overlay ${header.object}`);
  const message: OverlayMessage = {
    name,
    frame: header.frame,
    count: header.count,
    floats: new Float32Array(),
    words: new Uint32Array(),
    byObject: new Map(),
  };
  if (name === 'contacts' || name === 'crossings') {
    const length = header.count * (name === 'contacts' ? CONTACT.words : 3);
    message.floats = new Float32Array(buffer, HEADER_BYTES, length);
    message.words = new Uint32Array(buffer, HEADER_BYTES, length);
    return message;
  }
  const width = name === 'velocities' || name === 'strain' ? 3 : 1,
    Type = name === 'patches' ? Uint32Array : Float32Array;
  let place = HEADER_BYTES;
  for (let k = 0; k < header.count; k++) {
    const object = view.getUint16(place, true),
      length = width * view.getUint32(place + 4, true);
    message.byObject.set(object, new Type(buffer, place + 8, length));
    place += 8 + 4 * length;
  }
  return message;
}

// Two 16-bit objects, then the triangles, of crossing `k`.
export function getCrossing(message: OverlayMessage, k: number): { objects: [number, number]; triangles: [number, number] } {
  const [objects, a, b] = message.words.subarray(3 * k, 3 * k + 3);
  return { objects: [objects & 0xffff, objects >>> 16], triangles: [a, b] };
}
