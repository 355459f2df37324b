// A film of a range of frames, made by the browser's own encoder as WebM. Each frame is waited for, drawn, and shown for its time.

export interface FilmJob {
  canvas: HTMLCanvasElement;
  from: number;
  to: number;
  framesPerSecond: number;
  show: (frame: number) => Promise<void>; // resolves when the frame is drawn
  tell: (done: number, count: number) => void;
  isStopped: () => boolean;
}

const TYPES = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'];

export function canFilm(): boolean {
  return typeof MediaRecorder !== 'undefined' && TYPES.some((type) => MediaRecorder.isTypeSupported(type));
}

const wait = (milliseconds: number) => new Promise((done) => setTimeout(done, Math.max(milliseconds, 0)));

// The film, or null where it was stopped.
export async function makeFilm(job: FilmJob): Promise<Blob | null> {
  const type = TYPES.find((each) => MediaRecorder.isTypeSupported(each))!;
  const stream = job.canvas.captureStream(0),
    track = stream.getVideoTracks()[0] as CanvasCaptureMediaStreamTrack;
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: 8e6 }),
    parts: Blob[] = [];
  const end = new Promise<void>((done, fail) => {
    recorder.onstop = () => done();
    recorder.onerror = () => fail(new Error('the browser could not make the film'));
  });
  recorder.ondataavailable = ({ data }) => parts.push(data);
  const pause = 1000 / job.framesPerSecond,
    count = job.to - job.from + 1;
  await job.show(job.from);
  recorder.start();
  for (let frame = job.from; frame <= job.to && !job.isStopped(); frame++) {
    recorder.pause();
    await job.show(frame); // the clock of the film stands while a frame is waited for
    recorder.resume();
    track.requestFrame();
    job.tell(frame - job.from + 1, count);
    await wait(pause);
  }
  recorder.stop();
  await end;
  track.stop();
  return job.isStopped() ? null : new Blob(parts, { type: 'video/webm' });
}
