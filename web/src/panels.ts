// The panels beside the picture: how it looks, overlays, what is chosen, the live scene, and what one takes away.
import * as THREE from 'three';
import { button, check, choose, get, make, write, writeVector } from './dom.ts';
import type { Hold, Tool } from './hold.ts';
import { OVERLAYS, type Overlays } from './overlays.ts';
import type { Picker, Selection } from './pick.ts';
import type { DocumentMessage, PickedMessage, Vector } from './protocol.ts';
import type { Stage } from './stage.ts';
import type { Look } from './surface.ts';

const NO_PATCH = 0; // the label of triangles that are in none

export type FullLook = Look & { hasGround: boolean };

function section(title: string, isOpen: boolean, ...children: (Node | string)[]): HTMLDetailsElement {
  return make('details', { open: isOpen }, make('summary', {}, title), make('div', { class: 'body' }, ...children));
}

// A slider with its number beside it.
function slide(
  label: string,
  range: { low: number; high: number; step: number },
  value: number,
  change: (value: number) => void,
): HTMLElement {
  const limits = { min: range.low, max: range.high, step: range.step };
  const slider = make('input', { type: 'range', ...limits, value, 'aria-label': label });
  const number = make('input', { type: 'number', step: range.step, value, 'aria-label': `${label}, as a number` });
  slider.addEventListener('input', () => {
    number.value = slider.value;
    change(Number(slider.value));
  });
  number.addEventListener('change', () => {
    if (number.value === '' || !Number.isFinite(Number(number.value))) return;
    slider.value = number.value;
    change(Number(number.value));
  });
  return make('div', { class: 'slide' }, make('span', { 'aria-hidden': 'true' }, label), slider, number);
}

function facts(rows: readonly (readonly [string, string | undefined])[]): HTMLElement {
  return make(
    'dl',
    { class: 'facts' },
    ...rows
      .filter(([, value]) => value !== undefined && value !== '')
      .flatMap(([name, value]) => [make('dt', {}, name), make('dd', {}, value!)]),
  );
}

// ---- how it looks ----

export function makeLookPanel(look: FullLook, apply: (look: FullLook) => void): HTMLDetailsElement {
  const change = (part: Partial<FullLook>) => apply(Object.assign(look, part));
  return section(
    'Look',
    true,
    choose(
      'Shading',
      [
        ['smooth', 'Smooth'],
        ['flat', 'Flat'],
      ],
      look.shading,
      (value) => change({ shading: value as Look['shading'] }),
    ),
    choose(
      'Texture',
      [
        ['plain', 'Plain'],
        ['checker', 'Checker'],
      ],
      look.texture,
      (value) => change({ texture: value as Look['texture'] }),
    ),
    check('Wireframe', look.hasWires, (hasWires) => change({ hasWires })),
    check('Shadows', look.hasShadows, (hasShadows) => change({ hasShadows })),
    check('Ground', look.hasGround, (hasGround) => change({ hasGround })),
  );
}

export function makeOverlayPanel(overlays: Overlays, names: readonly string[]): HTMLDetailsElement {
  const shown = OVERLAYS.filter(({ source }) => names.includes(source));
  const boxes = shown.map(({ key, label }) => {
    const box = check(label, overlays.active.has(key), (isOn) => {
      overlays.toggle(key, isOn);
      // Of those that color surfaces one is on at a time.
      boxes.forEach((each, k) => (each.querySelector('input')!.checked = overlays.active.has(shown[k].key)));
    });
    return box;
  });
  return section('Overlays', true, ...(boxes.length ? boxes : [make('p', { class: 'quiet' }, 'This document has none.')]));
}

export function makeObjectPanel(stage: Stage, frame: (object: number) => void): HTMLDetailsElement {
  const rows = stage.surfaces.slice(0, 200).map((surface, object) => {
    const { name, role, triangle_count: count } = surface.info;
    const box = check(
      name,
      surface.isShown,
      (isOn) => {
        surface.isShown = surface.group.visible = isOn;
        stage.ask();
      },
      make('span', { class: 'quiet' }, `${role}, ${count.toLocaleString('en')}`),
    );
    return make(
      'div',
      { class: 'row' },
      box,
      button('Frame', () => frame(object), { 'aria-label': `Frame ${name}` }),
    );
  });
  return section(`Objects (${stage.surfaces.length})`, false, ...rows);
}

// ---- what is chosen ----

export interface SelectionActions {
  chooseVertex: (object: number, vertex: number) => boolean;
  choosePart: (part: Selection['part']) => void;
  frame: () => void;
  grab: () => void;
  letGo: () => void;
  nudge: (right: number, up: number, nearer: number) => void;
  cut: () => void;
  clear: () => void;
}

export class SelectionPanel {
  readonly element: HTMLDetailsElement;
  private readonly content = make('div', {});
  private readonly finder = make('div', {});
  private readonly actions: SelectionActions;
  private readonly stage: Stage;

  constructor(stage: Stage, actions: SelectionActions) {
    this.stage = stage;
    this.actions = actions;
    this.element = section('Selection', true, this.content, this.finder);
  }

  setDocument(document: DocumentMessage): void {
    const object = choose(
      'Object',
      document.objects.slice(0, 500).map(({ name }, k) => [String(k), name] as const),
      '0',
      () => {},
    );
    const vertex = make('input', { type: 'number', min: 0, value: 0, 'aria-label': 'Vertex' });
    const find = () => this.actions.chooseVertex(Number(object.querySelector('select')!.value), Number(vertex.value));
    vertex.addEventListener('keydown', (event) => event.key === 'Enter' && find());
    this.finder.replaceChildren(
      make('h2', {}, 'By number'),
      object,
      make('label', { class: 'field' }, make('span', {}, 'Vertex'), vertex),
      button('Choose', find),
    );
    this.show(null, null);
  }

  show(selection: Selection | null, picked: PickedMessage | null, hold?: { isAble: boolean; isHolding: boolean }): void {
    if (!selection) {
      this.content.replaceChildren(make('p', { class: 'quiet' }, 'Click on a surface, or choose a vertex by its number.'));
      return;
    }
    const { actions } = this,
      info = this.stage.surfaces[selection.object]?.info;
    const parts = make(
      'div',
      { class: 'group', role: 'group', 'aria-label': 'Part' },
      ...(['vertex', 'edge', 'triangle'] as const).map((part) =>
        button(part[0].toUpperCase() + part.slice(1), () => actions.choosePart(part), {
          'aria-pressed': part === selection.part,
        }),
      ),
    );
    const canHold = hold?.isAble && info && info.role !== 'obstacle';
    this.content.replaceChildren(
      make('p', {}, make('b', {}, info?.name ?? ''), ` (${info?.role ?? ''})`),
      parts,
      ...(picked ? this.describe(selection, picked) : [make('p', { class: 'quiet' }, 'asking')]),
      make(
        'div',
        { class: 'row' },
        button('Frame', actions.frame),
        button('Clear', actions.clear),
        ...(canHold
          ? [
              hold!.isHolding ? button('Let go', actions.letGo, { class: 'main' }) : button('Hold here', actions.grab),
              button('Cut pin', actions.cut, { disabled: picked?.vertex?.is_pinned === false }),
            ]
          : []),
      ),
      ...(canHold && hold!.isHolding ? [this.makePads()] : []),
    );
  }

  // Buttons that move what is held.
  private makePads(): HTMLElement {
    const { nudge } = this.actions;
    return make(
      'div',
      { class: 'pads', role: 'group', 'aria-label': 'Move what is held' },
      button('Away', () => nudge(0, 0, -1)),
      button('Up', () => nudge(0, 1, 0)),
      button('Nearer', () => nudge(0, 0, 1)),
      button('Left', () => nudge(-1, 0, 0)),
      button('Down', () => nudge(0, -1, 0)),
      button('Right', () => nudge(1, 0, 0)),
    );
  }

  private describe(selection: Selection, picked: PickedMessage): Node[] {
    const { vertex, edge, triangle, contacts } = picked;
    const percent = (value: number | undefined) => (value === undefined ? undefined : `${write(100 * value)} %`);
    const count = Array.isArray(vertex?.triangles) ? vertex.triangles.length : vertex?.triangles;
    const rows: [string, string | undefined][] =
      selection.part === 'vertex' && vertex
        ? [
            ['Vertex', String(vertex.index)],
            ['Position [m]', writeVector(vertex.position ?? picked.position, 7)],
            ['Velocity [m/s]', vertex.velocity && writeVector(vertex.velocity)],
            ['Speed [m/s]', vertex.velocity && write(Math.hypot(...vertex.velocity))],
            ['Mass [kg]', vertex.mass === undefined ? undefined : write(vertex.mass)],
            ['Pin', vertex.is_pinned === undefined ? undefined : vertex.is_pinned ? 'pinned' : 'free'],
            ['Triangles', count === undefined ? undefined : String(count)],
          ]
        : selection.part === 'edge' && edge
          ? [
              ['Edge', edge.vertices?.join(', ')],
              ['Length [m]', edge.length === undefined ? undefined : write(edge.length, 5)],
              ['At rest [m]', edge.rest_length === undefined ? undefined : write(edge.rest_length, 5)],
              ['Strain', percent(edge.strain)],
            ]
          : [
              ['Triangle', triangle && String(triangle.index)],
              ['Vertices', triangle?.vertices?.join(', ')],
              ['Area [m\u00b2]', triangle?.area === undefined ? undefined : write(triangle.area)],
              ['Warp', percent(triangle?.strain?.warp)],
              ['Weft', percent(triangle?.strain?.weft)],
              ['Shear', percent(triangle?.strain?.shear)],
              [
                'Patch',
                typeof triangle?.patch !== 'number' ? undefined : triangle.patch === NO_PATCH ? 'none' : String(triangle.patch),
              ],
            ];
    const nodes: Node[] = [facts([...rows, ['Point [m]', writeVector(picked.position, 7)], ['Frame', String(picked.frame)]])];
    if (!contacts) return nodes;
    nodes.push(make('h2', {}, contacts.length === 1 ? '1 contact' : `${contacts.length} contacts`));
    for (const contact of contacts.slice(0, 12)) {
      const other = typeof contact.object === 'number' ? this.stage.surfaces[contact.object]?.info.name : contact.object;
      const impulse = Array.isArray(contact.impulse)
        ? writeVector(contact.impulse, 3)
        : contact.impulse === undefined
          ? undefined
          : write(contact.impulse);
      nodes.push(
        make(
          'div',
          { class: `contact ${contact.kind}` },
          facts([
            ['Kind', contact.kind],
            ['With', [other, contact.features ?? ''].filter(Boolean).join(', ')],
            ['Gap [mm]', contact.gap === undefined ? undefined : write(1000 * contact.gap)],
            ['Normal', contact.normal && writeVector(contact.normal, 3)],
            ['Impulse [N s]', impulse],
          ]),
        ),
      );
    }
    if (contacts.length > 12) nodes.push(make('p', { class: 'quiet' }, `and ${contacts.length - 12} more`));
    return nodes;
  }
}

// ---- a live scene ----

export function makeHoldPanel(hold: Hold): { element: HTMLDetailsElement; update: () => void } {
  const tools: [Tool, string, string][] = [
    ['look', 'Look', 'V'],
    ['grab', 'Grab', 'G'],
    ['cut', 'Cut pins', 'X'],
    ['move', 'Move', 'M'],
  ];
  const buttons = tools.map(([tool, label, key]) =>
    button(label, () => hold.setTool(tool), { 'aria-pressed': hold.tool === tool, title: `${label} (${key})` }),
  );
  const words: Record<Tool, string> = {
    look: 'Drag turns the view; with Shift it pulls.',
    grab: 'Drag cloth or a body to pull it; drag beside it to turn the view.',
    cut: 'Click a pinned vertex to set it free.',
    move: 'Click an obstacle or a body, then drag its arrows, or type where it is to go.',
  };
  const help = make('p', { class: 'quiet' }),
    mover = make('div', {});
  // The force of the slider goes by powers of ten.
  const force = slide(
    'Force [N]',
    { low: 0.1, high: 100, step: 0.1 },
    hold.force,
    (value) => (hold.force = Math.max(value, 1e-6)),
  );
  const update = () => {
    buttons.forEach((each, k) => each.setAttribute('aria-pressed', String(tools[k][0] === hold.tool)));
    help.textContent = words[hold.tool];
    mover.replaceChildren(...(hold.tool === 'move' && hold.moved !== null ? [makeMover(hold)] : []));
  };
  update();
  return {
    element: section(
      'Hold',
      true,
      make('div', { class: 'group', role: 'group', 'aria-label': 'Tool' }, ...buttons),
      help,
      force,
      mover,
    ),
    update,
  };
}

// Numbers of the place that an object is to go to.
function makeMover(hold: Hold): HTMLElement {
  const pose = hold.getPose()!,
    turn = new THREE.Euler().setFromQuaternion(pose.rotation, 'XYZ');
  const place = pose.position.toArray(),
    angles = [turn.x, turn.y, turn.z].map((angle) => (180 * angle) / Math.PI);
  const fields = (title: string, values: number[], step: number) => {
    const inputs = values.map((value, k) =>
      make('input', { type: 'number', step, value: Number(value.toFixed(4)), 'aria-label': `${title} ${'xyz'[k]}` }),
    );
    return {
      inputs,
      element: make(
        'fieldset',
        {},
        make('legend', {}, title),
        make(
          'div',
          { class: 'vector' },
          ...inputs.map((input, k) => make('label', {}, make('span', { 'aria-hidden': 'true' }, 'xyz'[k]), input)),
        ),
      ),
    };
  };
  const position = fields('Middle [m]', place, 0.01),
    rotation = fields('Turn [\u00b0]', angles, 1);
  const go = () => {
    const [x, y, z] = rotation.inputs.map((input) => (Number(input.value) * Math.PI) / 180);
    hold.move(
      new THREE.Vector3(...position.inputs.map((input) => Number(input.value))),
      new THREE.Quaternion().setFromEuler(new THREE.Euler(x, y, z, 'XYZ')),
    );
  };
  for (const input of [...position.inputs, ...rotation.inputs])
    input.addEventListener('keydown', (event) => event.key === 'Enter' && go());
  return make(
    'div',
    {},
    make(
      'div',
      { class: 'row' },
      button('Arrows', () => hold.setGizmo('translate')),
      button('Rings', () => hold.setGizmo('rotate')),
    ),
    position.element,
    rotation.element,
    button('Move there', go, { class: 'main' }),
  );
}

export function makeSettingsPanel(
  document: DocumentMessage,
  set: (what: string, value: number | number[] | string, object?: number) => void,
): HTMLDetailsElement {
  const { settings } = document,
    gravity = settings?.gravity ?? [0, 0, -9.81],
    wind = settings?.wind ?? [0, 0, 0];
  const vector = (label: string, value: Vector | number[], what: string, limit: number, step: number) => {
    const now = [...value];
    return make(
      'fieldset',
      {},
      make('legend', {}, label),
      ...['x', 'y', 'z'].map((axis, k) =>
        slide(`${what === 'wind' ? 'Wind' : 'Gravity'} ${axis}`, { low: -limit, high: limit, step }, now[k], (part) => {
          now[k] = part;
          set(what, [...now]);
        }),
      ),
    );
  };
  const cloths = document.objects
    .map((info, object) => ({ info, object }))
    .filter(({ info }) => info.role === 'cloth')
    .slice(0, 20);
  const presets = settings?.presets ?? [];
  const fabrics = !presets.length
    ? []
    : cloths.map(({ info, object }) => {
        const now = settings?.materials?.[info.name] ?? info.material ?? '';
        const options = presets.map((name) => [name, name] as const);
        const field = choose(
          info.name,
          presets.includes(now) ? options : [['', now || 'as in the scene'], ...options],
          presets.includes(now) ? now : '',
          (value) => value && set('material', value, object),
        );
        return field;
      });
  const frictions = cloths.map(({ info, object }) =>
    slide(info.name, { low: 0, high: 1, step: 0.01 }, info.friction ?? 0.3, (value) => set('friction', value, object)),
  );
  return section(
    'Scene',
    true,
    vector('Wind [m/s]', wind, 'wind', 20, 0.1),
    slide('Gusts [m/s]', { low: 0, high: 20, step: 0.1 }, settings?.gusts ?? 0, (value) => set('gusts', value)),
    vector('Gravity [m/s\u00b2]', gravity, 'gravity', 20, 0.01),
    ...(fabrics.length ? [make('fieldset', {}, make('legend', {}, 'Fabric'), ...fabrics)] : []),
    ...(frictions.length ? [make('fieldset', {}, make('legend', {}, 'Friction'), ...frictions)] : []),
  );
}

// ---- what one takes away ----

export interface TakeActions {
  picture: () => void;
  film: (from: number, to: number, framesPerSecond: number) => void;
  stopFilm: () => void;
  link: () => void;
  recording: () => void;
  session: () => void;
}

export function makeTakePanel(actions: TakeActions, document: DocumentMessage, canFilm: boolean): HTMLDetailsElement {
  const parts: Node[] = [make('div', { class: 'row' }, button('Picture', actions.picture), button('Copy link', actions.link))];
  if (document.live)
    parts.push(
      make('div', { class: 'row' }, button('Recording', actions.recording), button('Save session', actions.session)),
      make('p', { class: 'quiet' }, 'The recording repeats this session bit for bit: tulle replay FILE.'),
    );
  if (document.frame_count > 1 && !document.live) {
    const number = (label: string, value: number) => make('input', { type: 'number', min: 0, value, 'aria-label': label });
    const from = number('First frame of the film', 0),
      to = number('Last frame of the film', document.frame_count - 1);
    const rate = number(
      'Frames a second of the film',
      Math.min(60, Math.max(1, Math.round(1 / (document.frame_seconds || 1 / 30)))),
    );
    const labelled = (text: string, input: HTMLElement) =>
      make('label', {}, make('span', { 'aria-hidden': 'true' }, text), input);
    parts.push(
      make('h2', {}, 'Film'),
      ...(canFilm
        ? [
            make('div', { class: 'vector' }, labelled('from', from), labelled('to', to), labelled('a second', rate)),
            make(
              'div',
              { class: 'row' },
              button('Make film', () => actions.film(Number(from.value), Number(to.value), Number(rate.value)), { id: 'film' }),
              button('Stop', actions.stopFilm, { id: 'film-stop', hidden: true }),
            ),
            make('p', { id: 'film-state', class: 'quiet' }),
          ]
        : [make('p', { class: 'quiet' }, 'This browser cannot make films; tulle render can.')]),
    );
  }
  return section('Take away', false, ...parts);
}

export function showFilmState(words: string, isRunning: boolean): void {
  const state = get('film-state');
  if (!state) return;
  state.textContent = words;
  get('film').hidden = isRunning;
  get('film-stop').hidden = !isRunning;
}

export type { Picker };
