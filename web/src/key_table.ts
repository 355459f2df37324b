// What each key does.
import type { Hold } from './hold.ts';
import type { Key } from './keys.ts';
import type { LiveBar } from './live.ts';
import type { Picker } from './pick.ts';
import type { Corner, Stage } from './stage.ts';
import type { Timeline } from './timeline.ts';

const TURN = Math.PI / 24,
  PAN = 0.08; // of a key: an angle; a share of the height of the picture

export interface KeyTarget {
  stage: Stage | null;
  hold: Hold | null;
  picker: Picker | null;
  timeline: Timeline;
  liveBar: LiveBar;
  corner: Corner;
  isLive: () => boolean;
  isShown: (tool: string) => boolean; // a button of the bar
  frameAll: () => void;
  frameSelection: () => void;
  lookAlong: (axis: string) => void;
  flipLook: (label: string) => void;
  togglePlots: () => void;
  togglePanels: () => void;
  toggleEditor: () => void;
  showKeys: () => void;
}

export function makeKeyTable(page: KeyTarget): Key[] {
  const camera = () => page.stage!.camera,
    live = page.isLive,
    holds = () => page.hold?.isByKeys ?? false;
  const drawn = () => page.stage !== null,
    able = () => page.hold?.isAble ?? false;
  const move = (right: number, up: number, nearer = 0) => page.hold!.nudge(right, up, nearer);
  const held = (keys: string[], shown: string, words: string, act: () => void): Key => ({
    keys,
    shown,
    words,
    act,
    isOn: holds,
    inView: true,
  });
  const view = (keys: string[], shown: string, words: string, act: (event: KeyboardEvent) => void): Key => ({
    keys,
    shown,
    words,
    act,
    isOn: drawn,
    inView: true,
  });
  const turn = (across: number, up: number) => (event: KeyboardEvent) =>
    event.shiftKey ? camera().pan(across * PAN, up * PAN) : camera().turn(across * TURN, up * TURN);
  return [
    held(['ArrowLeft'], 'arrows', 'moves what is held', () => move(-1, 0)),
    held(['ArrowRight'], '', '', () => move(1, 0)),
    held(['ArrowUp'], '', '', () => move(0, 1)),
    held(['ArrowDown'], '', '', () => move(0, -1)),
    held(['PageUp'], 'Page Up, Page Down', 'moves it away, nearer', () => move(0, 0, -1)),
    held(['PageDown'], '', '', () => move(0, 0, 1)),
    held(['Enter', 'Escape'], 'Enter', 'lets go', () => page.hold!.letGo()),
    view(['ArrowLeft'], 'arrows', 'turn the view; with Shift move it', turn(-1, 0)),
    view(['ArrowRight'], '', '', turn(1, 0)),
    view(['ArrowUp'], '', '', turn(0, 1)),
    view(['ArrowDown'], '', '', turn(0, -1)),
    view(['+', '='], '+ \u2212', 'nearer, away', () => camera().turn(0, 0, 1 / 1.15)),
    view(['-'], '', '', () => camera().turn(0, 0, 1.15)),
    view(['Home'], 'Home', 'frames all', () => page.frameAll()),
    view(['f'], 'F', 'frames what is chosen', () => page.frameSelection()),
    ...(['1', '2', '3'] as const).map((key, k) =>
      view([key], k ? '' : '1 2 3', k ? '' : 'views along x, y, z', () => page.lookAlong('xyz'[k])),
    ),
    {
      keys: [' '],
      shown: 'space',
      words: 'plays, pauses',
      act: () => (live() ? page.liveBar.toggle() : page.timeline.toggle()),
    },
    {
      keys: ['.'],
      shown: ', .',
      words: 'a frame back, on; of a live scene: a step on',
      act: () => (live() ? page.liveBar.step(1) : page.timeline.go(1)),
    },
    { keys: ['>'], shown: '>', words: 'ten steps on', act: () => page.liveBar.step(10), isOn: live },
    { keys: [','], shown: '', words: '', act: () => page.timeline.go(-1), isOn: () => !live() },
    { keys: ['['], shown: '[ ]', words: 'first, last frame', act: () => page.timeline.go(-Infinity), isOn: () => !live() },
    { keys: [']'], shown: '', words: '', act: () => page.timeline.go(Infinity), isOn: () => !live() },
    { keys: ['r'], shown: 'R', words: 'resets the scene', act: () => page.liveBar.reset(), isOn: live },
    {
      keys: ['v'],
      shown: 'V G X M',
      words: 'tools: look, grab, cut pins, move',
      act: () => page.hold!.setTool('look'),
      isOn: able,
    },
    { keys: ['g'], shown: '', words: '', act: () => page.hold!.setTool('grab'), isOn: able },
    { keys: ['x'], shown: '', words: '', act: () => page.hold!.setTool('cut'), isOn: able },
    { keys: ['m'], shown: '', words: '', act: () => page.hold!.setTool('move'), isOn: able },
    { keys: ['h'], shown: 'H', words: 'takes hold of what is chosen', act: () => page.hold!.grabSelection(), isOn: able },
    { keys: ['w'], shown: 'W', words: 'wireframe', act: () => page.flipLook('Wireframe'), isOn: drawn },
    { keys: ['s'], shown: 'S', words: 'shadows', act: () => page.flipLook('Shadows'), isOn: drawn },
    { keys: ['p'], shown: 'P', words: 'plots', act: () => page.togglePlots(), isOn: () => page.isShown('plots') },
    { keys: ['n'], shown: 'N', words: 'panels', act: () => page.togglePanels() },
    { keys: ['e'], shown: 'E', words: 'editor', act: () => page.toggleEditor(), isOn: () => page.isShown('editor') },
    {
      keys: ['c'],
      shown: 'C',
      words: 'counts of frames drawn and received',
      act: () => page.corner.toggle(Boolean(page.corner.element.hidden)),
    },
    {
      keys: ['Escape'],
      shown: 'Escape',
      words: 'lets go, clears the selection',
      act: () => (page.hold?.isHolding ? page.hold.letGo() : page.picker?.select(null)),
    },
    { keys: ['?'], shown: '?', words: 'this list', act: () => page.showKeys() },
  ];
}
