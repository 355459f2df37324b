// The keys, and the list of them.
import { button, get, make } from './dom.ts';

export interface Key {
  keys: string[]; // as KeyboardEvent.key, letters in lower case
  shown: string;
  words: string;
  act: (event: KeyboardEvent) => void;
  isOn?: () => boolean;
  inView?: boolean; // only where the picture has the focus: other places use these keys themselves
}

const TYPING =
  'input:not([type=checkbox]):not([type=range]):not([type=radio]), textarea, select, [contenteditable=true], .editor-host';

export function handleKeys(keys: readonly Key[], view: HTMLElement): void {
  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target as HTMLElement,
      name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (target.closest('dialog')) return;
    const isInView = target === view;
    if (!isInView && target.closest(TYPING)) return;
    // Buttons, sliders and lists keep the keys that work them.
    const isControl = target.closest('button, summary, input, a') !== null;
    for (const key of keys) {
      if (!key.keys.includes(name) || (key.inView && !isInView) || (key.isOn && !key.isOn())) continue;
      if (isControl && !isInView && [' ', 'Enter', 'Home', 'End', 'PageUp', 'PageDown'].includes(name)) return;
      event.preventDefault();
      key.act(event);
      return;
    }
  });
}

export function showKeys(keys: readonly Key[], about: string): void {
  const dialog = get<HTMLDialogElement>('keys');
  const rows = keys
    .filter((key) => key.words && (!key.isOn || key.isOn()))
    .map(({ shown, words }) => make('tr', {}, make('th', { scope: 'row' }, make('kbd', {}, shown)), make('td', {}, words)));
  dialog.replaceChildren(
    make('h2', { id: 'keys-title' }, 'Keys'),
    make('table', {}, make('tbody', {}, ...rows)),
    make(
      'p',
      {},
      'By mouse: drag turns, right drag moves, the wheel goes nearer, a click tells about what is there. By finger: one turns, two move and zoom.',
    ),
    make('p', { class: 'quiet' }, about),
    button('Close', () => dialog.close(), { class: 'main' }),
  );
  dialog.showModal();
}
