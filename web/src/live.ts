// The bar of a live scene: start, pause, step, reset, rewind, and where it is.
import { button, choose, make, makeIcon, write } from './dom.ts';
import type { StateMessage } from './protocol.ts';
import { ICON } from './timeline.ts';

export class LiveBar {
  readonly element = make('div', { class: 'transport', role: 'group', 'aria-label': 'Simulation' });
  state: StateMessage | null = null;
  private readonly start: HTMLButtonElement;
  private readonly speed: HTMLLabelElement;
  private readonly rewind = make('select', { 'aria-label': 'Rewind to' });
  private readonly time = make('output', { class: 'time live-time', 'aria-live': 'off' });
  private readonly command: (message: { type: string; [name: string]: unknown }) => void;
  private readonly say: (words: string) => void;

  constructor(command: (message: { type: string; [name: string]: unknown }) => void, say: (words: string) => void) {
    this.command = command;
    this.say = say;
    const withIcon = (label: string, path: string, act: () => void) => {
      const made = button('', act, { class: 'tool', 'aria-label': label, title: label });
      made.append(makeIcon(path));
      return made;
    };
    const speeds = [
      ['0.1', '0.1 \u00d7'],
      ['0.25', '0.25 \u00d7'],
      ['1', '1 \u00d7'],
      ['0', 'full speed'],
    ] as const;
    this.speed = choose('Speed of the simulation', speeds, '1', () => this.isRunning && this.run());
    this.speed.classList.add('bare');
    this.start = withIcon('Start', ICON.play, () => this.toggle());
    this.rewind.addEventListener('change', () => {
      if (this.rewind.value === '') return;
      command({ type: 'rewind', step: Number(this.rewind.value) });
      say(`rewound to step ${this.rewind.value}`);
      this.rewind.value = '';
    });
    this.element.append(
      make(
        'div',
        { class: 'buttons' },
        withIcon('Reset', ICON.reset, () => this.reset()),
        this.start,
        withIcon('Step', ICON.forward, () => this.step(1)),
      ),
      this.time,
      this.speed,
      make('label', { class: 'field bare' }, make('span', {}, 'Rewind'), this.rewind),
    );
    this.show(null);
  }

  get isRunning(): boolean {
    return this.state?.is_running ?? false;
  }

  toggle(): void {
    if (this.isRunning) this.command({ type: 'pause' });
    else this.run();
  }

  private run(): void {
    this.command({ type: 'run', speed: Number(this.speed.querySelector('select')!.value) });
  }

  step(count: number): void {
    this.command({ type: 'step', count });
  }

  reset(): void {
    this.command({ type: 'reset' });
    this.say('reset to the start');
  }

  show(state: StateMessage | null): void {
    const wasRunning = this.isRunning,
      had = this.state;
    this.state = state;
    const label = this.isRunning ? 'Pause' : 'Start';
    if (this.start.getAttribute('aria-label') !== label || !had) {
      this.start.setAttribute('aria-label', label);
      this.start.title = label;
      this.start.replaceChildren(makeIcon(this.isRunning ? ICON.pause : ICON.play));
    }
    if (had && state && wasRunning !== state.is_running)
      this.say(state.is_running ? 'running' : `paused at step ${state.step}`);
    if (!state) {
      this.time.textContent = '';
      return;
    }
    const rate = state.is_running
      ? `, ${write(state.steps_per_second)} steps a second, ${write(state.real_time_ratio, 2)} \u00d7 real time`
      : state.has_failed
        ? ', stopped'
        : state.is_starting
          ? ', starting'
          : ', paused';
    this.time.textContent = `step ${state.step}, ${state.time.toFixed(2)} s${rate}, ${state.contacts} contacts`;
    this.time.dataset.step = String(state.step);
    const saved = state.saved ?? [],
      wanted = ['', ...saved.map(String)];
    const now = [...this.rewind.options].map(({ value }) => value);
    if (document.activeElement === this.rewind || (wanted.length === now.length && wanted.join() === now.join())) return;
    this.rewind.replaceChildren(
      make('option', { value: '' }, 'Rewind to \u2026'),
      ...saved.map((step) => make('option', { value: step }, `step ${step}`)),
    );
  }
}
