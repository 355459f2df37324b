// The frames of a run that the page holds, and those it asks for. Memory is bounded: what is farthest from the frame that is shown
// goes first, and its arrays are used again. The newest wish wins: a request ends the one before.
import type { FrameDecoder, Header, OverlayMessage } from './protocol.ts';

export interface KeptFrame {
  frame: number;
  time: number;
  positions: (Float32Array | null)[]; // null: those of the mesh
  isAbsent: Uint8Array;
  overlays: Map<string, OverlayMessage>;
  asked: Set<string>; // overlays that come, maybe later
  bytes: number;
}

const AHEAD = 90; // frames of a request
const PATIENCE = 400; // milliseconds for the first frame of a request before a newer wish is sent

export class FrameStore {
  private readonly frames = new Map<number, KeptFrame>();
  private readonly spare = new Map<number, Float32Array[]>();
  private bytes = 0;
  private readonly limit: number;

  constructor(limit: number) {
    this.limit = limit;
  }

  get(frame: number): KeptFrame | undefined {
    return this.frames.get(frame);
  }

  get count(): number {
    return this.frames.size;
  }

  get size(): number {
    return this.bytes;
  }

  // Keeps what the decoder holds now. `shown` is the frame that must stay.
  keep(header: Header, decoder: FrameDecoder, shown: number, asked: readonly string[]): KeptFrame {
    this.drop(header.frame);
    const { objects } = decoder;
    const kept: KeptFrame = {
      frame: header.frame,
      time: header.time,
      overlays: new Map(),
      asked: new Set(asked),
      bytes: 0,
      positions: [],
      isAbsent: new Uint8Array(objects.length),
    };
    objects.forEach((object, k) => {
      kept.isAbsent[k] = Number(object.isAbsent);
      if (!object.hasMoved) return kept.positions.push(null);
      const array = this.spare.get(object.positions.length)?.pop() ?? new Float32Array(object.positions.length);
      array.set(object.positions);
      kept.bytes += array.byteLength;
      return kept.positions.push(array);
    });
    kept.bytes += 256; // beside the positions
    this.bytes += kept.bytes;
    this.frames.set(header.frame, kept);
    this.trim(shown, header.frame);
    return kept;
  }

  addOverlay(message: OverlayMessage, shown: number): void {
    const kept = this.frames.get(message.frame);
    if (!kept) return;
    let bytes = message.floats.byteLength;
    for (const array of message.byObject.values()) bytes += array.byteLength;
    kept.overlays.set(message.name, message);
    kept.bytes += bytes;
    this.bytes += bytes;
    this.trim(shown, message.frame);
  }

  private trim(shown: number, newest: number): void {
    while (this.bytes > this.limit && this.frames.size > 2) {
      let farthest = -1,
        distance = -1;
      for (const frame of this.frames.keys()) {
        // Frames behind are less likely to be wanted than those ahead.
        const away = frame < shown ? 2 * (shown - frame) : frame - shown;
        if (frame === newest || frame === shown || away <= distance) continue;
        farthest = frame;
        distance = away;
      }
      this.drop(farthest);
    }
  }

  private drop(frame: number): void {
    const kept = this.frames.get(frame);
    if (!kept) return;
    this.frames.delete(frame);
    this.bytes -= kept.bytes;
    for (const array of kept.positions) {
      if (!array) continue;
      const pile = this.spare.get(array.length);
      if (!pile) this.spare.set(array.length, [array]);
      else if (pile.length < 8) pile.push(array);
    }
  }

  clear(): void {
    this.frames.clear();
    this.spare.clear();
    this.bytes = 0;
  }
}

export interface FrameRequest {
  type: 'frames';
  from: number;
  count: number;
  step: number;
  exact: boolean;
  [name: string]: unknown;
}

// Decides what to ask for.
export class Fetcher {
  private pending: { from: number; step: number; end: number; next: number; sent: number } | null = null;
  private wish: { frame: number; step: number } | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly store: FrameStore;
  private readonly send: (request: FrameRequest) => void;
  private readonly isUsable: (kept: KeptFrame) => boolean;
  private frameCount: number;

  constructor(
    store: FrameStore,
    frameCount: number,
    send: (request: FrameRequest) => void,
    isUsable: (kept: KeptFrame) => boolean,
  ) {
    this.store = store;
    this.frameCount = frameCount;
    this.send = send;
    this.isUsable = isUsable;
  }

  setFrameCount(count: number): void {
    this.frameCount = count;
  }

  has(frame: number): boolean {
    const kept = this.store.get(frame);
    return kept !== undefined && this.isUsable(kept);
  }

  // Forgets what was asked for: the connection is another one, or frames come with other overlays.
  reset(): void {
    this.pending = null;
    this.wish = null;
  }

  // Whether a frame belongs to the newest request.
  expects(frame: number): boolean {
    return this.pending !== null && frame >= this.pending.next && frame < this.pending.end;
  }

  private isComing(frame: number): boolean {
    const { pending } = this;
    return (
      pending !== null &&
      frame >= pending.next &&
      frame < pending.end &&
      (frame - pending.from) % pending.step === 0 &&
      frame - pending.next < 8 * pending.step
    );
  }

  // `frame` is to be shown now, those after it by `step` soon.
  want(frame: number, step: number): void {
    if (this.has(frame)) {
      // What is ahead: the first frame that is missing.
      let missing = frame;
      const horizon = Math.min(frame + (AHEAD / 2) * step, this.frameCount);
      while (missing < horizon && this.has(missing)) missing += step;
      if (missing >= horizon || (this.pending && missing >= this.pending.next && missing < this.pending.end)) return;
      this.ask(missing, step);
    } else if (!this.isComing(frame)) this.ask(frame, step);
  }

  private ask(frame: number, step: number): void {
    const { pending } = this,
      now = performance.now();
    // A request whose first frame has not come yet is left alone for a moment, so that scrubbing does not outrun the server.
    if (pending && pending.next === pending.from && now - pending.sent < PATIENCE) {
      this.wish = { frame, step };
      this.timer ||= setTimeout(() => this.grant(), PATIENCE);
      return;
    }
    this.wish = null;
    const count = Math.max(1, Math.min(AHEAD, Math.ceil((this.frameCount - frame) / step)));
    this.pending = { from: frame, step, end: frame + count * step, next: frame, sent: now };
    this.send({ type: 'frames', from: frame, count, step, exact: false });
  }

  // A frame came.
  take(frame: number): void {
    const { pending, wish } = this;
    if (pending && frame >= pending.next && frame < pending.end) pending.next = frame + pending.step;
    if (pending && pending.next >= pending.end) this.pending = null;
    if (wish) this.grant();
  }

  // Asks for what was wished for meanwhile.
  private grant(): void {
    const { wish } = this;
    clearTimeout(this.timer);
    this.timer = undefined;
    this.wish = null;
    if (wish && !this.has(wish.frame) && !this.isComing(wish.frame)) this.ask(wish.frame, wish.step);
  }
}
