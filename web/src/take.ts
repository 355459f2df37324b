// What one takes away: a picture, a film, the recording.
import { download, make } from './dom.ts';
import { makeFilm } from './film.ts';
import { showFilmState } from './panels.ts';
import type { Stage } from './stage.ts';
import type { Timeline } from './timeline.ts';

export interface TakeOptions {
  stage: Stage;
  timeline: Timeline;
  getName: () => string; // of the document's file
  fail: (problem: unknown) => void;
}

export class Take {
  private isFilming = false;
  private readonly o: TakeOptions;

  constructor(options: TakeOptions) {
    this.o = options;
  }

  private get fileName(): string {
    return (
      this.o
        .getName()
        .replace(/\.[a-z]+$/i, '')
        .replace(/[^\w.-]+/g, '_') || 'tulle'
    );
  }

  picture(): void {
    this.o.stage
      .takePicture()
      .then((blob) => download(`${this.fileName}_${this.o.stage.view.dataset.frame ?? 0}.png`, blob))
      .catch((problem) => this.o.fail(problem));
  }

  recording(): void {
    const link = make('a', { href: 'recording', download: `${this.fileName}.tulle` });
    document.body.append(link);
    link.click();
    link.remove();
  }

  async film(first: number, last: number, framesPerSecond: number): Promise<void> {
    const { stage, timeline } = this.o;
    const from = Math.min(Math.max(Math.round(first), 0), timeline.last),
      to = Math.min(Math.max(Math.round(last), from), timeline.last);
    if (this.isFilming || !Number.isFinite(from + to)) return;
    timeline.pause();
    this.isFilming = stage.mustBeSharp = true;
    stage.setCoarse(false);
    try {
      const film = await makeFilm({
        canvas: stage.canvas,
        from,
        to,
        framesPerSecond: Math.min(Math.max(framesPerSecond || 30, 1), 120),
        isStopped: () => !this.isFilming,
        show: async (frame) => {
          timeline.setFrame(frame);
          while (this.o.stage.view.dataset.frame !== String(frame) && this.isFilming) {
            await new Promise((done) => setTimeout(done, 5));
            timeline.refresh();
          }
          stage.draw();
          stage.finish();
        },
        tell: (done, count) => showFilmState(`frame ${done} of ${count}`, true),
      });
      if (film) download(`${this.fileName}.webm`, film);
      showFilmState(film ? `${to - from + 1} frames, ${(film.size / 1e6).toFixed(1)} MB` : 'stopped', false);
    } catch (problem) {
      this.o.fail(problem);
      showFilmState('', false);
    }
    this.isFilming = stage.mustBeSharp = false;
  }

  stopFilm(): void {
    this.isFilming = false;
  }
}
