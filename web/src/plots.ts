// Plots along the timeline: energies, contacts, the solve, times of stages. The least and the greatest value of each bucket of steps
// is drawn, so no peak is lost. A click goes there; a line shows where the timeline is.
import { choose, make, write } from './dom.ts';
import type { SeriesMessage } from './protocol.ts';

export interface PlotGroup {
  key: string;
  label: string;
  names: string[];
  unit: string;
}

const DASHES = [[], [6, 3], [2, 2], [8, 3, 2, 3], [12, 4], [4, 4]];
const LIGHT = ['#1a5fa8', '#b45309', '#047857', '#a21caf', '#b91c1c', '#4d5866'];
const DARK = ['#7db3f0', '#f0b35e', '#5fd0a0', '#e39af0', '#f58f8f', '#b6c0cc'];
const HEIGHT = 120,
  LEFT = 52,
  BOTTOM = 16;

// The groups of the columns that there are.
export function groupSeries(series: readonly { name: string; unit: string }[]): PlotGroup[] {
  const rules: [string, string, (name: string) => boolean][] = [
    ['energy', 'Energy', (name) => /energy|kinetic|elastic|gravity/.test(name)],
    ['contacts', 'Contacts', (name) => /contacts$/.test(name)],
    ['solve', 'Solve', (name) => /cg_iterations|solve_count|impact_rounds|substeps|pair_searches/.test(name)],
    ['times', 'Stage times', (name) => /seconds$/.test(name)],
    ['gap', 'Smallest gap', (name) => name === 'smallest_gap'],
    ['stretch', 'Largest stretch', (name) => name === 'max_stretch'],
  ];
  const groups = rules.map(([key, label, accepts]) => {
    const members = series.filter(({ name }) => accepts(name));
    return { key, label, names: members.map(({ name }) => name), unit: members[0]?.unit ?? '' };
  });
  return groups.filter(({ names }) => names.length > 0);
}

const label = (name: string) => name.replace(/_energy$|_seconds$/, '').replaceAll('_', ' ');

export class Plots {
  readonly element = make('div', { class: 'plots' });
  onPick: (step: number) => void = () => {};
  private readonly canvas = make('canvas', { role: 'img', 'aria-label': 'Plot', class: 'plot' });
  private readonly legend = make('ul', { class: 'plot-legend' });
  private readonly ask: (group: PlotGroup, buckets: number) => Promise<SeriesMessage>;
  private groups: PlotGroup[] = [];
  private group: PlotGroup | null = null;
  private data: SeriesMessage | null = null;
  private step = 0;
  private isAsking = false;
  private isStale = false;
  private timer = 0;

  constructor(ask: (group: PlotGroup, buckets: number) => Promise<SeriesMessage>) {
    this.ask = ask;
    new ResizeObserver(() => this.load()).observe(this.canvas);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.draw());
    const pick = (event: PointerEvent) => {
      const { data } = this,
        box = this.canvas.getBoundingClientRect();
      if (!data || data.steps.length < 1) return;
      const part = Math.min(Math.max((event.clientX - box.left - LEFT) / (box.width - LEFT - 4), 0), 1);
      this.onPick(data.steps[0] + part * (data.steps.at(-1)! - data.steps[0]));
    };
    this.canvas.addEventListener('pointerdown', (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      pick(event);
    });
    this.canvas.addEventListener('pointermove', (event) => event.buttons & 1 && pick(event));
  }

  setSeries(series: readonly { name: string; unit: string }[]): void {
    this.groups = groupSeries(series);
    this.group = this.groups.find(({ key }) => key === this.group?.key) ?? this.groups[0] ?? null;
    const chooser = choose(
      'Plot',
      this.groups.map(({ key, label: text }) => [key, text] as const),
      this.group?.key ?? '',
      (key) => {
        this.group = this.groups.find((each) => each.key === key) ?? null;
        this.data = null;
        this.load();
      },
    );
    const head = make('div', { class: 'plot-head' }, chooser, this.legend);
    this.element.replaceChildren(
      ...(this.group ? [head, this.canvas] : [make('p', {}, 'This document has no series to plot.')]),
    );
    this.load();
  }

  // Asks for the numbers again, soon and not twice at a time.
  load(): void {
    this.isStale = true;
    clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.fetch(), 80);
  }

  private async fetch(): Promise<void> {
    const { group } = this,
      width = this.canvas.clientWidth;
    if (this.isAsking || !this.isStale || !group || width < 40 || !this.element.isConnected) return;
    this.isAsking = true;
    this.isStale = false;
    try {
      const data = await this.ask(group, Math.max(16, Math.floor((width - LEFT) / 2)));
      if (group === this.group) this.data = data;
    } catch {
      // The connection was lost; another load follows when it is back.
    }
    this.isAsking = false;
    this.draw();
    if (this.isStale) this.load();
  }

  setStep(step: number): void {
    this.step = step;
    this.draw();
  }

  private draw(): void {
    const { canvas, data, group } = this,
      width = canvas.clientWidth,
      scale = Math.min(window.devicePixelRatio, 2);
    const context = canvas.getContext('2d');
    if (!context || !group || width < 40) return;
    if (canvas.width !== Math.round(width * scale)) canvas.width = Math.round(width * scale);
    if (canvas.height !== HEIGHT * scale) canvas.height = HEIGHT * scale;
    const isDark = matchMedia('(prefers-color-scheme: dark)').matches,
      colors = isDark ? DARK : LIGHT;
    const ink = isDark ? '#b6c0cc' : '#4d5866',
      line = isDark ? '#3a424d' : '#d5dae1';
    context.setTransform(scale, 0, 0, scale, 0, 0);
    context.clearRect(0, 0, width, HEIGHT);
    context.font = '11px system-ui, sans-serif';
    context.fillStyle = ink;
    if (!data || data.steps.length === 0) {
      context.fillText('No steps yet', LEFT, HEIGHT / 2);
      return;
    }
    let low = Infinity,
      high = -Infinity;
    for (const name of group.names)
      for (const values of [data.low[name], data.high[name]])
        for (const value of values ?? [])
          if (value !== null && Number.isFinite(value)) {
            low = Math.min(low, value);
            high = Math.max(high, value);
          }
    if (!(high >= low)) [low, high] = [0, 1];
    if (low > 0 && low < 0.6 * high) low = 0;
    if (high === low) high = low + (Math.abs(low) || 1);
    const first = data.steps[0],
      last = Math.max(data.steps.at(-1)!, first + 1);
    const x = (step: number) => LEFT + ((step - first) / (last - first)) * (width - LEFT - 4);
    const y = (value: number) => 6 + (1 - (value - low) / (high - low)) * (HEIGHT - BOTTOM - 10);
    context.strokeStyle = line;
    context.lineWidth = 1;
    context.textAlign = 'right';
    for (const value of [low, (low + high) / 2, high]) {
      context.beginPath();
      context.moveTo(LEFT, y(value));
      context.lineTo(width - 4, y(value));
      context.stroke();
      context.fillText(write(value), LEFT - 5, y(value) + 4);
    }
    context.textAlign = 'left';
    context.fillText(`step ${first}`, LEFT, HEIGHT - 3);
    context.textAlign = 'right';
    context.fillText(String(data.steps.at(-1)), width - 4, HEIGHT - 3);
    group.names.forEach((name, k) =>
      this.drawSeries(context, { x, y }, data, name, colors[k % colors.length], DASHES[Math.floor(k % 6)]),
    );
    context.setLineDash([]);
    context.strokeStyle = isDark ? '#ffffff' : '#10161e';
    context.lineWidth = 1.5;
    const at = x(Math.min(Math.max(this.step, first), last));
    context.beginPath();
    context.moveTo(at, 2);
    context.lineTo(at, HEIGHT - BOTTOM + 2);
    context.stroke();
    this.writeLegend(data, group, colors);
  }

  private drawSeries(
    context: CanvasRenderingContext2D,
    { x, y }: { x: (step: number) => number; y: (value: number) => number },
    data: SeriesMessage,
    name: string,
    color: string,
    dash: number[],
  ): void {
    const lows = data.low[name] ?? [],
      highs = data.high[name] ?? [];
    context.strokeStyle = color;
    context.lineWidth = 1.5;
    context.setLineDash(dash);
    context.beginPath();
    let isDown = false;
    data.steps.forEach((step, k) => {
      const least = lows[k],
        greatest = highs[k];
      if (least === null || greatest === null || !Number.isFinite(least) || !Number.isFinite(greatest)) {
        isDown = false;
        return;
      }
      if (isDown) context.lineTo(x(step), y(greatest));
      else context.moveTo(x(step), y(greatest));
      if (greatest !== least) context.lineTo(x(step), y(least));
      isDown = true;
    });
    context.stroke();
  }

  private writeLegend(data: SeriesMessage, group: PlotGroup, colors: readonly string[]): void {
    let place = 0;
    while (place + 1 < data.steps.length && data.steps[place + 1] <= this.step) place++;
    const words: string[] = [];
    const rows = group.names.map((name, k) => {
      const low = data.low[name]?.[place],
        high = data.high[name]?.[place],
        isNumber = low !== null && low !== undefined;
      const value = !isNumber ? '\u2013' : low === high ? write(low) : `${write(low)} to ${write(high)}`;
      const line = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
      line.setAttribute('viewBox', '0 0 22 4');
      line.setAttribute('class', 'dash');
      line.setAttribute('aria-hidden', 'true');
      const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
      path.setAttribute('d', 'M0 2h22');
      path.setAttribute('stroke', colors[k % colors.length]);
      path.setAttribute('stroke-dasharray', DASHES[k % 6].join(' ') || 'none');
      line.append(path);
      words.push(`${label(name)} ${value}`);
      return make('li', {}, line, make('span', {}, label(name)), make('b', {}, value));
    });
    this.legend.replaceChildren(...rows);
    const unit = group.unit && group.unit !== '1' ? ` [${group.unit}]` : '';
    this.canvas.setAttribute('aria-label', `${group.label}${unit} at step ${Math.round(this.step)}: ${words.join(', ')}`);
    this.canvas.title = `${group.label}${unit}: click to go there`;
  }
}
