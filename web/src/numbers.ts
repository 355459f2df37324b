// Where nothing can be drawn: numbers in place of the picture.
import { get, make, write } from './dom.ts';
import type { DocumentMessage, StateMessage } from './protocol.ts';

export interface Numbers {
  document: DocumentMessage | null;
  state: StateMessage | null;
  frame: number;
  time: number; // [s]
}

export function showNumbers(stage: HTMLElement, { document, state, frame, time }: Numbers): void {
  let place = get('numbers');
  if (!place) {
    place = make('div', { id: 'numbers', class: 'numbers' });
    stage.append(place);
  }
  const rows: [string, string][] = [];
  if (document) {
    for (const { name, role, vertex_count, triangle_count } of document.objects.slice(0, 50))
      rows.push([name, `${role}, ${vertex_count} vertices, ${triangle_count} triangles`]);
    rows.push(['Frame', `${document.live ? (state?.frame ?? 0) : frame}`], ['Time', `${(state?.time ?? time).toFixed(3)} s`]);
  }
  if (state) {
    rows.push(['Step', String(state.step)], ['Contacts', String(state.contacts)]);
    for (const [name, value] of Object.entries(state.energies)) rows.push([`${name} energy`, `${write(value, 4)} J`]);
  }
  place.replaceChildren(
    make('h2', {}, 'This browser cannot draw: it has no WebGL 2. These are the numbers.'),
    make(
      'table',
      {},
      make(
        'tbody',
        {},
        ...rows.map(([name, value]) => make('tr', {}, make('th', { scope: 'row' }, name), make('td', {}, value))),
      ),
    ),
  );
}
