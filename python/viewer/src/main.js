// The viewer of tulle.show: builds its page from a film that tulle.notebook packed.
import { mapValue, toCss } from '../../../web/src/color.ts';
import { readFilm } from './film.js';
import { Player } from './player.js';
import { canDraw, Stage } from './stage.js';
import style from './style.css';

const HELP = 'Drag to turn, right drag to move, wheel to go nearer. Keys: arrows turn, plus and minus go nearer and away, '
  + 'space plays, comma and full stop go by a frame, W shows the mesh, Home shows everything.';
const TURN = Math.PI / 24;

function make(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

function makeLegend({ title, unit, low, high, map }) {
  const stops = Array.from({ length: 17 }, (_, k) => toCss(mapValue(map, k / 16))).join(', ');
  const bar = make('div', { class: 'scale' });
  bar.style.background = `linear-gradient(to right, ${stops})`;
  const write = (value) => Number(value.toPrecision(3)).toString().replace('-', '\u2212');
  return make('div', { class: 'legend' }, make('span', {}, `${title} [${unit}]`), bar,
    make('div', { class: 'ends' }, make('span', {}, write(low)), make('span', {}, write(high))));
}

function handleKeys(view, stage, player, edges) {
  const actions = {
    ArrowLeft: () => stage.turn(-TURN, 0), ArrowRight: () => stage.turn(TURN, 0),
    ArrowUp: () => stage.turn(0, TURN), ArrowDown: () => stage.turn(0, -TURN),
    '+': () => stage.turn(0, 0, 1 / 1.15), '=': () => stage.turn(0, 0, 1 / 1.15), '-': () => stage.turn(0, 0, 1.15),
    ' ': () => player.toggle(), ',': () => player.go(-1), '.': () => player.go(1),
    w: () => edges.click(), Home: () => stage.reset(),
  };
  view.addEventListener('keydown', (event) => {
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (!action || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    action();
  });
}

// Shows the film in the page in place of its text; throws where that cannot be.
export function start(buffer, text) {
  const film = readFilm(buffer);
  if (!canDraw()) throw new Error('it has no WebGL 2');
  document.head.append(make('style', {}, style));
  const view = make('div', { class: 'view', tabindex: 0, role: 'application', 'aria-roledescription': '3D view', 'aria-label': film.about,
    'aria-describedby': 'help', title: HELP });
  const parts = {
    play: make('button', { type: 'button', 'aria-label': 'Play' }, '\u25b6\ufe0e'),
    slider: make('input', { type: 'range', min: 0, value: 0, 'aria-label': 'Frame' }),
    time: make('span', { class: 'time', 'aria-hidden': 'true' }),
  };
  const edges = make('button', { type: 'button', 'aria-pressed': 'false' }, 'Mesh');
  const whole = make('button', { type: 'button', 'aria-label': 'Show everything' }, 'Reset');
  const bar = make('div', { class: 'bar', role: 'group', 'aria-label': 'Controls' },
    ...(film.frameCount > 1 ? [parts.play, parts.slider, parts.time] : [make('span', { class: 'time' }, film.title)]), edges, whole);
  if (film.scale) view.append(makeLegend(film.scale));
  text.replaceWith(view, bar, ...(film.note ? [make('p', { class: 'note' }, film.note)] : []), make('p', { id: 'help', hidden: '' }, HELP));
  const stage = new Stage(view, film);
  const player = new Player(film, parts, (frame) => stage.setFrame(frame));
  edges.addEventListener('click', () => {
    const isShown = edges.getAttribute('aria-pressed') === 'false';
    edges.setAttribute('aria-pressed', isShown);
    stage.setEdges(isShown);
  });
  whole.addEventListener('click', () => stage.reset());
  handleKeys(view, stage, player, edges);
}
