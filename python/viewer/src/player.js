// Which frame is shown: by time while it plays, else by the slider. Frames are shown as they are, none in between: what lies
// between two states was never accepted, and might intersect.
import { describeFrame, getShowTimes } from './film.js';

const STILL = matchMedia('(prefers-reduced-motion: reduce)');

export class Player {
  constructor(film, parts, show) {
    Object.assign(this, { film, parts, show });
    this.times = getShowTimes(film);
    this.frame = 0;
    this.isPlaying = false;
    parts.slider.max = film.frameCount - 1;
    parts.slider.addEventListener('input', () => {
      this.pause();
      this.setFrame(Number(parts.slider.value));
    });
    parts.play.addEventListener('click', () => this.toggle());
    document.addEventListener('visibilitychange', () => document.hidden && this.pause());
    this.setFrame(film.startFrame);
  }

  setFrame(frame) {
    this.frame = Math.min(Math.max(frame, 0), this.film.frameCount - 1);
    const text = describeFrame(this.film, this.frame);
    this.parts.slider.value = this.frame;
    this.parts.slider.setAttribute('aria-valuetext', text.spoken);
    this.parts.time.textContent = text.short;
    this.show(this.frame);
  }

  go(count) {
    this.pause();
    this.setFrame(this.frame + count);
  }

  toggle() {
    this.isPlaying ? this.pause() : this.play();
  }

  play() {
    const { times, film } = this;
    if (film.frameCount < 2) return;
    if (this.frame === film.frameCount - 1) this.setFrame(0);
    this.setPlaying(true);
    let last = performance.now(), time = times[this.frame];
    const step = (now) => {
      if (!this.isPlaying) return;
      time += Math.min(now - last, 250) / 1000;
      last = now;
      const pause = (times.at(-1) / (film.frameCount - 1)) * 1.001; // the last frame is shown as long as others
      if (time > times.at(-1) + pause) {
        if (STILL.matches) return this.go(film.frameCount); // motion ends by itself where little of it is wanted
        time = 0;
      }
      let frame = time < times[this.frame] ? 0 : this.frame;
      while (frame + 1 < film.frameCount && times[frame + 1] <= time) frame++;
      if (frame !== this.frame) this.setFrame(frame);
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    if (this.isPlaying) this.setPlaying(false);
  }

  setPlaying(isPlaying) {
    this.isPlaying = isPlaying;
    this.parts.play.textContent = isPlaying ? '\u275a\u275a' : '\u25b6\ufe0e';
    this.parts.play.setAttribute('aria-label', isPlaying ? 'Pause' : 'Play');
  }
}
