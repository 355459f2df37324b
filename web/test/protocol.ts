// Unit tests of the messages, of what is kept and asked for, of links, and of the place of a cursor in YAML.
import assert from 'node:assert/strict';
import test from 'node:test';
import * as THREE from 'three';
import { isInView } from '../src/in_view.ts';
import { findPath } from '../src/path.ts';
import { Fetcher, FrameStore, type FrameRequest } from '../src/frames.ts';
import { readLink, writeLink } from '../src/link.ts';
import { FrameDecoder, getCrossing, readHeader, readMesh, readOverlay } from '../src/protocol.ts';

// ---- messages as the server writes them ----

class Writer {
  private readonly bytes: number[] = [];
  private readonly view = new DataView(new ArrayBuffer(8));

  private put(size: number): this {
    for (let k = 0; k < size; k++) this.bytes.push(this.view.getUint8(k));
    return this;
  }

  u8(...values: number[]): this {
    this.bytes.push(...values);
    return this;
  }

  u16(...values: number[]): this {
    for (const value of values) (this.view.setUint16(0, value, true), this.put(2));
    return this;
  }

  u32(...values: number[]): this {
    for (const value of values) (this.view.setUint32(0, value, true), this.put(4));
    return this;
  }

  f32(...values: number[]): this {
    for (const value of values) (this.view.setFloat32(0, value, true), this.put(4));
    return this;
  }

  f64(value: number): this {
    this.view.setFloat64(0, value, true);
    return this.put(8);
  }

  head(kind: number, object: number, frame: number, sequence: number, count: number): this {
    return this.u8(kind, 1)
      .u16(object)
      .u32(frame)
      .f64(frame / 30)
      .u32(sequence, count);
  }

  align(): this {
    while (this.bytes.length % 4) this.bytes.push(0);
    return this;
  }

  get buffer(): ArrayBuffer {
    return new Uint8Array(this.bytes).buffer;
  }
}

// A small generator, so that a failure can be repeated.
function makeRandom(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return state / 4294967296;
  };
}

const N = 150; // two whole blocks of 64 vertices and a part of one

function makeMesh(): ReturnType<typeof readMesh> {
  const positions = Array.from({ length: 3 * N }, (_, i) => i / 8);
  return readMesh(
    new Writer()
      .head(1, 0, 0, 0, 0)
      .u32(N, 2, 0)
      .f32(...positions)
      .u32(0, 1, 2, 2, 1, 149).buffer,
  );
}

const key = (sequence: number, low: number[], step: number, q: ArrayLike<number>) =>
  new Writer()
    .head(2, 0, sequence, sequence, 1)
    .u16(0)
    .u8(2, 0)
    .u32(N)
    .f32(...low, step)
    .u16(...Array.from(q))
    .align();

test('a mesh is read, and one that is damaged is not', () => {
  const mesh = makeMesh();
  assert.equal(mesh.vertexCount, N);
  assert.deepEqual([...mesh.corners], [0, 1, 2, 2, 1, 149]);
  assert.equal(mesh.positions[7], 7 / 8);
  assert.equal(mesh.uv, null);
  const withUv = readMesh(
    new Writer()
      .head(1, 3, 0, 0, 0)
      .u32(3, 1, 1)
      .f32(...Array(9).fill(1))
      .u32(0, 1, 2)
      .f32(0, 0, 1, 0, 0, 1).buffer,
  );
  assert.deepEqual([...withUv.uv!], [0, 0, 1, 0, 0, 1]);
  assert.equal(withUv.object, 3);
  assert.throws(
    () =>
      readMesh(
        new Writer()
          .head(1, 0, 0, 0, 0)
          .u32(3, 1, 0)
          .f32(...Array(9).fill(1))
          .u32(0, 1, 3).buffer,
      ),
    /not there/,
  );
  assert.throws(() => readMesh(new Writer().head(1, 0, 0, 0, 0).u32(4000000000, 1, 0).buffer));
  assert.throws(() => readHeader(new ArrayBuffer(23)), /shorter/);
  assert.throws(() => readHeader(new Writer().u8(1, 2).u16(0).u32(0).f64(0).u32(0, 0).buffer), /version 2/);
});

test('keys and differences give back the steps that were sent, exactly', () => {
  const random = makeRandom(7),
    decoder = new FrameDecoder([makeMesh()]),
    low = [-1, 0.5, 2],
    step = 0.0078125;
  let q = Uint16Array.from({ length: 3 * N }, () => Math.floor(65536 * random()));
  decoder.read(key(1, low, step, q).buffer);
  const check = () => {
    for (let i = 0; i < q.length; i++) assert.equal(decoder.objects[0].positions[i], Math.fround(low[i % 3] + step * q[i]));
  };
  check();
  for (let sequence = 2; sequence < 60; sequence++) {
    const next = q.slice(),
      widths = [0, 1, 2].map(() => Math.floor(3 * random()));
    const writer = new Writer().head(2, 0, sequence, sequence, 1).u16(0).u8(3, 0).u32(N);
    widths.forEach((width, block) => {
      writer.u8(width);
      for (let i = 192 * block; i < Math.min(192 * (block + 1), 3 * N); i++) {
        const difference = Math.floor(256 * random()) - 128;
        if (width === 1) {
          next[i] = q[i] + difference; // wraps around as the server's does
          writer.u8(difference & 255);
        } else if (width === 2) {
          next[i] = Math.floor(65536 * random());
          writer.u16(next[i]);
        }
      }
    });
    q = next;
    const header = decoder.read(writer.align().buffer);
    assert.equal(header.sequence, sequence);
    check();
  }
});

test('exact, unchanged and absent objects', () => {
  const decoder = new FrameDecoder([makeMesh()]),
    [state] = decoder.objects;
  const exact = Array.from({ length: 3 * N }, (_, i) => Math.fround(Math.sin(i)));
  decoder.read(
    new Writer()
      .head(2, 0, 1, 1, 1)
      .u16(0)
      .u8(1, 0)
      .u32(N)
      .f32(...exact).buffer,
  );
  assert.deepEqual([...state.positions], exact);
  assert.ok(state.hasMoved);
  const { revision } = state;
  decoder.read(new Writer().head(2, 0, 2, 2, 1).u16(0).u8(0, 0).u32(N).buffer);
  assert.deepEqual([...state.positions], exact);
  assert.equal(state.revision, revision);
  decoder.read(new Writer().head(2, 0, 3, 3, 1).u16(0).u8(0, 1).u32(N).buffer);
  assert.ok(state.isAbsent && state.revision > revision);
});

test('a damaged frame is refused', () => {
  const decoder = new FrameDecoder([makeMesh()]);
  const difference = (...blocks: number[]) =>
    new Writer()
      .head(2, 0, 1, 1, 1)
      .u16(0)
      .u8(3, 0)
      .u32(N)
      .u8(...blocks)
      .align().buffer;
  assert.throws(() => decoder.read(difference(0, 0, 0)), /before a whole one/);
  decoder.read(key(1, [0, 0, 0], 1, new Uint16Array(3 * N)).buffer);
  assert.throws(() => decoder.read(difference(3, 0, 0)), /damaged/);
  assert.throws(() => decoder.read(difference(1, 0, 0)), /damaged/);
  assert.throws(() => decoder.read(new Writer().head(2, 0, 1, 1, 1).u16(1).u8(0, 0).u32(N).buffer), /fit/);
  assert.throws(
    () =>
      decoder.read(
        new Writer()
          .head(2, 0, 1, 1, 1)
          .u16(0)
          .u8(0, 0)
          .u32(N + 1).buffer,
      ),
    /fit/,
  );
  assert.throws(() => decoder.read(new Writer().head(2, 0, 1, 1, 1).u16(0).u8(9, 0).u32(N).buffer), /coding 9/);
  const whole = key(1, [0, 0, 0], 1, new Uint16Array(3 * N)).buffer;
  for (let length = 0; length < whole.byteLength; length += 7) assert.throws(() => decoder.read(whole.slice(0, length)));
});

test('overlays are read', () => {
  const contacts = readOverlay(new Writer().head(3, 1, 5, 0, 1).f32(1, 2, 3, 0, 0, 1, 4, 5, 6, 0.25).u32(6).buffer);
  assert.equal(contacts.name, 'contacts');
  assert.deepEqual([...contacts.floats.subarray(0, 10)], [1, 2, 3, 0, 0, 1, 4, 5, 6, 0.25]);
  assert.equal(contacts.words[10], 6);
  const gaps = readOverlay(new Writer().head(3, 5, 5, 0, 2).u16(0, 0).u32(2).f32(1, Infinity).u16(3, 0).u32(1).f32(2).buffer);
  assert.deepEqual([...gaps.byObject.keys()], [0, 3]);
  assert.deepEqual([...gaps.byObject.get(0)!], [1, Infinity]);
  const strain = readOverlay(new Writer().head(3, 4, 5, 0, 1).u16(0, 0).u32(1).f32(0.5, 0.25, -1).buffer);
  assert.deepEqual([...strain.byObject.get(0)!], [0.5, 0.25, -1]);
  const patches = readOverlay(new Writer().head(3, 3, 5, 0, 1).u16(0, 0).u32(2).u32(7, 4294967295).buffer);
  assert.deepEqual([...patches.byObject.get(0)!], [7, 4294967295]);
  const crossings = readOverlay(new Writer().head(3, 6, 5, 0, 1).u16(2, 9).u32(11, 12).buffer);
  assert.deepEqual(getCrossing(crossings, 0), { objects: [2, 9], triangles: [11, 12] });
  assert.throws(() => readOverlay(new Writer().head(3, 9, 5, 0, 0).buffer), /no overlay 9/);
  assert.throws(() => readOverlay(new Writer().head(3, 1, 5, 0, 4000000000).buffer));
});

// ---- what is kept, what is asked for ----

test('the store is bounded, keeps the frame that is shown, and uses arrays again', () => {
  const decoder = new FrameDecoder([makeMesh()]),
    frameBytes = 12 * N,
    store = new FrameStore(20 * (frameBytes + 300));
  const arrays = new Set<Float32Array>();
  for (let frame = 0; frame < 10000; frame++) {
    decoder.read(key(frame, [frame, 0, 0], 1, new Uint16Array(3 * N)).buffer);
    const kept = store.keep({ kind: 2, object: 0, frame, time: 0, sequence: frame, count: 1 }, decoder, 40, []);
    arrays.add(kept.positions[0]!);
    assert.equal(kept.positions[0]![0], frame);
  }
  assert.ok(store.count <= 20 && store.size <= 20 * (frameBytes + 300), `${store.count} frames, ${store.size} bytes`);
  assert.equal(store.get(40)?.positions[0]![0], 40, 'the frame that is shown went');
  assert.ok(store.get(41) && store.get(9999) && !store.get(5000));
  assert.ok(arrays.size < 40, `${arrays.size} arrays were made`);
});

test('the newest wish wins', () => {
  const sent: FrameRequest[] = [],
    store = new FrameStore(1e9),
    decoder = new FrameDecoder([makeMesh()]);
  const fetcher = new Fetcher(
    store,
    10000,
    (request) => sent.push(request),
    () => true,
  );
  fetcher.want(100, 1);
  for (let frame = 200; frame < 300; frame++) fetcher.want(frame, 1); // scrubbing, faster than the server
  assert.deepEqual(
    sent.map(({ from }) => from),
    [100],
    'more than one request is under way',
  );
  const come = (frame: number) => {
    store.keep({ kind: 2, object: 0, frame, time: 0, sequence: 1, count: 1 }, decoder, frame, []);
    fetcher.take(frame);
  };
  come(100);
  assert.deepEqual(
    sent.map(({ from }) => from),
    [100, 299],
  );
  come(299);
  fetcher.want(299, 1);
  assert.equal(sent.length, 2, 'what is coming is asked for again');
  for (let frame = 300; frame < 299 + sent[1].count; frame++) come(frame);
  fetcher.want(299 + sent[1].count - 10, 1);
  assert.equal(sent[2].from, 299 + sent[1].count, 'what comes next is not asked for');
  fetcher.want(9998, 1);
  assert.ok(
    sent.every(({ from, count, step }) => from + (count - 1) * step <= 9999),
    'frames behind the last one are asked for',
  );
});

// ---- links, places in YAML ----

test('a link gives back the view', () => {
  const link = {
    frame: 12,
    camera: [1, -2.5, 3, 0, 0, 0.25],
    overlays: ['contacts', 'warp'],
    look: { shading: 'flat' as const, texture: 'checker' as const, hasWires: true, hasShadows: false, hasGround: true },
    selection: { object: 1, triangle: 77, weights: [0.5, 0.25, 0.25] as [number, number, number], part: 'edge' as const },
  };
  assert.deepEqual(readLink(`#${writeLink(link)}`), link);
  assert.deepEqual(readLink('#frame=-1&camera=1,2&selection=a,b,c,d,e,f'), {});
  assert.deepEqual(readLink('#frame=1e999&camera=1,2,3,4,5,x'), {});
});

test('the keys that lead to a place in YAML', () => {
  const text = `title: a
time: {step: 1/90 s, du}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [2, 2]}
    material:
      preset: co
obstacles:
- name: ground
  mot
`;
  const at = (end: string) => findPath(text, text.indexOf(end) + end.length);
  assert.deepEqual(at('tit'), { path: [], isValue: false, key: '' });
  assert.deepEqual(at('du'), { path: ['time'], isValue: false, key: '' });
  assert.deepEqual(at('- na'), { path: ['cloth'], isValue: false, key: '' });
  assert.deepEqual(at('    mesh: {sha'), { path: ['cloth', 'mesh'], isValue: false, key: '' });
  assert.deepEqual(at('shape: rect'), { path: ['cloth', 'mesh'], isValue: true, key: 'shape' });
  assert.deepEqual(at('      pre'), { path: ['cloth', 'material'], isValue: false, key: '' });
  assert.deepEqual(at('preset: co'), { path: ['cloth', 'material'], isValue: true, key: 'preset' });
  assert.deepEqual(at('  mot'), { path: ['obstacles'], isValue: false, key: '' });
});

// ---- what a view frames ----

test('a view frames the cloth and what is near it and of its size, not the floor', () => {
  const box = (...numbers: number[]) => new THREE.Box3(new THREE.Vector3(...numbers.slice(0, 3)), new THREE.Vector3(...numbers.slice(3)));
  const cloth = box(-0.5, -0.5, 0, 0.5, 0.5, 1); // its diagonal is 1.73 m
  assert.ok(isInView(cloth, cloth));
  assert.ok(isInView(cloth, box(-0.3, -0.3, -0.5, 0.3, 0.3, 0.5)), 'a ball under it');
  assert.ok(isInView(cloth, box(0.7, 0, 0, 1.2, 0.1, 0.1)), 'something 0.2 m beside it');
  assert.ok(!isInView(cloth, box(0.8, 0, 0, 1.2, 0.1, 0.1)), 'something 0.3 m beside it');
  assert.ok(!isInView(cloth, box(-1, -1, 0, 1, 1, 0)), 'a floor of twice its size');
  assert.ok(!isInView(cloth, box(-50, -50, -1, 50, 50, 0)), 'ground');
  assert.ok(isInView(new THREE.Box3(), box(-50, -50, -1, 50, 50, 0)), 'ground without cloth');
});
