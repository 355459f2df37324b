// The connection to the server: requests with answers, frames as they come, and a new try when it is lost.
import { SUBPROTOCOL } from './protocol.ts';

export interface Answer {
  type: string;
  id?: number;
  [name: string]: unknown;
}

export interface Listener {
  onText(message: Answer): void;
  onBinary(buffer: ArrayBuffer): void;
  onStatus(status: 'connecting' | 'open' | 'lost', reason: string): void;
}

const FIRST_PAUSE = 500,
  LONGEST_PAUSE = 8000; // milliseconds before a new try

export class Connection {
  private socket: WebSocket | null = null;
  private nextId = 1;
  private pause = FIRST_PAUSE;
  private timer = 0;
  private readonly waiting = new Map<number, { done: (answer: Answer) => void; fail: (problem: Error) => void }>();
  private readonly url: string;
  private readonly listener: Listener;

  constructor(url: string, listener: Listener) {
    this.url = url;
    this.listener = listener;
    this.open();
    window.addEventListener('online', () => this.retry());
  }

  get isOpen(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  private open(): void {
    this.listener.onStatus('connecting', '');
    const socket = new WebSocket(this.url, SUBPROTOCOL);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => {
      this.pause = FIRST_PAUSE;
      this.listener.onStatus('open', '');
    };
    socket.onmessage = ({ data }: MessageEvent<string | ArrayBuffer>) => {
      if (this.socket !== socket) return;
      if (typeof data !== 'string') this.listener.onBinary(data);
      else this.take(JSON.parse(data) as Answer);
    };
    socket.onclose = ({ reason }) => {
      if (this.socket !== socket) return;
      this.socket = null;
      for (const { fail } of this.waiting.values()) fail(new Error('the connection was lost'));
      this.waiting.clear();
      this.listener.onStatus('lost', reason);
      this.timer = window.setTimeout(() => this.open(), this.pause);
      this.pause = Math.min(2 * this.pause, LONGEST_PAUSE);
    };
  }

  // Tries again now.
  retry(): void {
    if (this.socket) return;
    clearTimeout(this.timer);
    this.open();
  }

  // Ends this connection and begins another one: what came over it made no sense.
  restart(reason: string): void {
    console.error(reason);
    this.socket?.close(4000, 'the page did not understand a message');
  }

  private take(message: Answer): void {
    const waiting = message.id === undefined ? undefined : this.waiting.get(message.id);
    if (!waiting) return this.listener.onText(message);
    this.waiting.delete(message.id!);
    if (message.type === 'error') waiting.fail(new Error(String(message.message)));
    else waiting.done(message);
  }

  // Says something that has no answer.
  send(message: { type: string; [name: string]: unknown }): void {
    if (this.isOpen) this.socket!.send(JSON.stringify(message));
  }

  // Asks for something; fails with the server's words.
  ask<T = Answer>(message: { type: string; [name: string]: unknown }): Promise<T> {
    if (!this.isOpen) return Promise.reject(new Error('there is no connection'));
    const id = this.nextId++;
    this.send({ ...message, id });
    return new Promise<Answer>((done, fail) => this.waiting.set(id, { done, fail })) as Promise<T>;
  }
}
