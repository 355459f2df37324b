// The timeline of a run: which frame is shown, by time while it plays, else by the slider. Frames are shown as they are, none in
// between: what lies between two states was never accepted, and might intersect.
import { button, choose, check, make, makeIcon, wantsLittleMotion } from './dom.ts';
import type { Fetcher, FrameStore, KeptFrame } from './frames.ts';

export const ICON = {
  play: 'M4 2.5v11l9-5.5z',
  pause: 'M4 3h3v10H4zM9 3h3v10H9z',
  back: 'M11 3v10L5 8zM3 3h2v10H3z',
  forward: 'M5 3v10l6-5zM11 3h2v10h-2z',
  first: 'M13 3v10L8 8zM8 3v10L3 8zM2 3h1.5v10H2z',
  last: 'M3 3v10l5-5zM8 3v10l5-5zM12.5 3H14v10h-1.5z',
  reset: 'M8 3a5 5 0 1 1-4.6 3l1.4.6A3.5 3.5 0 1 0 8 4.5V7L4.2 3.8 8 .6z',
};
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4, 8];
const PICTURES = 60; // a second at most; faster play leaves frames out

export class Timeline {
  readonly element = make('div', { class: 'transport', role: 'group', 'aria-label': 'Timeline' });
  readonly slider = make('input', { type: 'range', min: 0, max: 0, value: 0, 'aria-label': 'Frame', class: 'scrubber' });
  frame = 0; // that is wanted
  isPlaying = false;
  speed = 1;
  doesLoop = false;
  doesFollow = false;
  onWant: (frame: number) => void = () => {};
  private readonly playButton: HTMLButtonElement;
  private readonly time = make('output', { class: 'time', 'aria-live': 'off' });
  private readonly store: FrameStore;
  private readonly fetcher: Fetcher;
  private readonly show: (kept: KeptFrame) => void;
  private readonly say: (words: string) => void;
  private readonly followBox: HTMLLabelElement;
  private frameCount = 1;
  private frameSeconds = 1 / 30;
  private shown = -1;

  constructor(store: FrameStore, fetcher: Fetcher, show: (kept: KeptFrame) => void, say: (words: string) => void) {
    Object.assign(this, { store, fetcher, show, say });
    this.store = store;
    this.fetcher = fetcher;
    this.show = show;
    this.say = say;
    const iconButton = (label: string, path: string, act: () => void) => {
      const made = button('', act, { 'aria-label': label, title: label, class: 'tool' });
      made.append(makeIcon(path));
      return made;
    };
    this.playButton = iconButton('Play', ICON.play, () => this.toggle());
    this.slider.addEventListener('input', () => {
      this.pause();
      this.doesFollow = this.setFollowBox(false);
      this.setFrame(Number(this.slider.value));
    });
    this.followBox = check('Follow', false, (isOn) => {
      this.doesFollow = isOn;
      if (isOn) this.setFrame(this.frameCount - 1);
    });
    this.followBox.hidden = true;
    const speed = choose(
      'Speed',
      SPEEDS.map((each) => [String(each), `${each} \u00d7`] as const),
      '1',
      (value) => (this.speed = Number(value)),
    );
    speed.classList.add('bare');
    this.element.append(
      make(
        'div',
        { class: 'buttons' },
        iconButton('First frame', ICON.first, () => this.go(-Infinity)),
        iconButton('Frame before', ICON.back, () => this.go(-1)),
        this.playButton,
        iconButton('Next frame', ICON.forward, () => this.go(1)),
        iconButton('Last frame', ICON.last, () => this.go(Infinity)),
      ),
      this.slider,
      this.time,
      speed,
      check('Loop', false, (isOn) => (this.doesLoop = isOn)),
      this.followBox,
    );
    document.addEventListener('visibilitychange', () => document.hidden && this.pause());
  }

  private setFollowBox(isOn: boolean): boolean {
    this.followBox.querySelector('input')!.checked = isOn;
    return isOn;
  }

  setRun(frameCount: number, frameSeconds: number, isUnderWay: boolean): void {
    const hasGrown = frameCount > this.frameCount && this.shown >= 0;
    this.frameCount = Math.max(frameCount, 1);
    if (frameSeconds > 0) this.frameSeconds = frameSeconds;
    this.slider.max = String(this.frameCount - 1);
    this.fetcher.setFrameCount(this.frameCount);
    this.followBox.hidden = !isUnderWay && !this.doesFollow;
    if (hasGrown && this.doesFollow) this.setFrame(this.frameCount - 1);
    else this.write();
  }

  get last(): number {
    return this.frameCount - 1;
  }

  get secondsPerFrame(): number {
    return this.frameSeconds;
  }

  private get stride(): number {
    return this.isPlaying ? Math.max(1, Math.floor(this.speed / this.frameSeconds / PICTURES)) : 1;
  }

  private write(): void {
    const kept = this.store.get(this.frame),
      seconds = kept?.time ?? this.frame * this.frameSeconds;
    this.slider.value = String(this.frame);
    this.slider.setAttribute('aria-valuetext', `frame ${this.frame} of ${this.last}, ${seconds.toFixed(2)} s`);
    this.time.textContent = `${this.frame} / ${this.last}, ${seconds.toFixed(2)} s`;
  }

  setFrame(frame: number): void {
    this.frame = Math.min(Math.max(Math.round(frame), 0), this.last);
    this.write();
    this.onWant(this.frame);
    this.refresh();
  }

  // Shows the wanted frame where it is there, and asks for what is missing.
  refresh(): void {
    const kept = this.store.get(this.frame);
    if (kept && kept.frame !== this.shown) {
      this.shown = kept.frame;
      this.show(kept);
    }
    this.fetcher.want(this.frame, this.stride);
  }

  // A frame came, or an overlay of one.
  take(frame: number): void {
    if (frame === this.frame) {
      this.shown = -1;
      this.write();
    }
    this.refresh();
  }

  // All frames are to come anew.
  forget(): void {
    this.shown = -1;
    this.fetcher.reset();
  }

  go(count: number): void {
    this.pause();
    this.setFrame(this.frame + Math.min(Math.max(count, -this.frameCount), this.frameCount));
    this.say(`frame ${this.frame}`);
  }

  toggle(): void {
    if (this.isPlaying) this.pause();
    else this.play();
  }

  play(): void {
    if (this.frameCount < 2) return;
    if (this.frame === this.last) this.setFrame(0);
    this.setPlaying(true);
    let last = performance.now(),
      place = this.frame;
    const step = (now: number) => {
      if (!this.isPlaying) return;
      const { stride } = this,
        next = this.frame + stride;
      // Time waits for frames that have not come.
      if (this.fetcher.has(Math.min(next, this.last)) || this.store.get(Math.min(next, this.last))) {
        place += (Math.min(now - last, 250) / 1000 / this.frameSeconds) * this.speed;
        place = Math.min(place, next + stride);
      } else this.fetcher.want(this.frame, stride);
      last = now;
      if (place >= this.last + 1) {
        if (!this.doesLoop || wantsLittleMotion.matches) {
          this.setFrame(this.last);
          return this.pause();
        }
        place = 0;
        this.setFrame(0);
      } else if (place >= next || place >= this.last) {
        const steps = Math.floor((place - this.frame) / stride);
        this.setFrame(Math.min(this.frame + Math.max(steps, 1) * stride, this.last));
      }
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause(): void {
    if (this.isPlaying) this.setPlaying(false);
  }

  private setPlaying(isPlaying: boolean): void {
    this.isPlaying = isPlaying;
    this.playButton.setAttribute('aria-label', isPlaying ? 'Pause' : 'Play');
    this.playButton.title = isPlaying ? 'Pause' : 'Play';
    this.playButton.replaceChildren(makeIcon(isPlaying ? ICON.pause : ICON.play));
    this.say(isPlaying ? 'playing' : `paused at frame ${this.frame}`);
  }
}
