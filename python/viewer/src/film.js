// What tulle.notebook packs, unpacked: the bodies, their positions in every frame, the values that color them.
//
// The bytes are the length of the header, the header as JSON, then for each body triangles (4 bytes each), positions (2), values (1).
// An array is stored in planes: all lowest bytes, then all next ones. Its numbers are differences: in the first frame from the entry
// before, in others from the frame before. Sums wrap around as the differences did.

class Reader {
  constructor(buffer) {
    this.bytes = new Uint8Array(buffer);
    const size = new DataView(buffer).getUint32(0, true);
    this.header = JSON.parse(new TextDecoder().decode(this.bytes.subarray(4, 4 + size)));
    this.place = 4 + size;
  }

  // Numbers of `Type` for `frames` frames of `count` entries with `width` numbers each.
  read(Type, frames, count, width) {
    const length = frames * count * width;
    const out = new Type(length);
    for (let plane = 0; plane < Type.BYTES_PER_ELEMENT; plane++, this.place += length)
      for (let i = 0; i < length; i++) out[i] |= this.bytes[this.place + i] << (8 * plane);
    const frame = count * width;
    for (let i = width; i < frame; i++) out[i] += out[i - width];
    for (let i = frame; i < length; i++) out[i] += out[i - frame];
    return out;
  }
}

class Body {
  constructor(reader, header) {
    Object.assign(this, header);
    this.triangles = reader.read(Uint32Array, 1, header.triangleCount, 3);
    this.steps = reader.read(Uint16Array, header.frameCount, header.vertexCount, 3);
    this.values = header.hasValues ? reader.read(Uint8Array, header.frameCount, header.vertexCount, 1) : null;
  }

  isPresent(frame) {
    return !this.present || this.present[frame] === 1;
  }

  // Number `axis` of a vertex [m]; a body that never moves has one frame.
  get(frame, vertex, axis) {
    const first = this.frameCount > 1 ? 3 * this.vertexCount * frame : 0;
    return this.low[axis] + this.step[axis] * this.steps[first + 3 * vertex + axis];
  }

  // The value of a vertex, 0 .. 1 of the scale.
  getValue(frame, vertex) {
    return this.values[(this.frameCount > 1 ? this.vertexCount * frame : 0) + vertex] / 255;
  }
}

export function readFilm(buffer) {
  const reader = new Reader(buffer);
  const film = reader.header;
  film.bodies = film.bodies.map((header) => new Body(reader, header));
  if (reader.place !== reader.bytes.length) throw new Error('the data are damaged');
  return film;
}

// When each frame is shown, in seconds from the first one; 30 a second where the film knows no times.
export function getShowTimes(film) {
  const times = film.times ?? Array.from({ length: film.frameCount }, (_, k) => k / 30);
  return times.map((time) => time - times[0]);
}

// "12 / 60, 0.40 s", and the same to be read out.
export function describeFrame(film, frame) {
  const number = film.numbers[frame], last = film.numbers[film.frameCount - 1];
  const time = film.times ? `, ${film.times[frame].toFixed(2)} s` : '';
  return { short: `${number} / ${last}${time}`, spoken: `frame ${number} of ${last}${time}` };
}
