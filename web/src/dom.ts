// Small things about elements.

type Child = Node | string;

export function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  attributes: Record<string, string | number | boolean> = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('aria-')) made.setAttribute(name, String(value));
    else if (value === true) made.setAttribute(name, '');
    else if (value !== false) made.setAttribute(name, String(value));
  }
  made.append(...children);
  return made;
}

const SVG = 'http://www.w3.org/2000/svg';

// A picture of 16 x 16 from the data of one path.
export function makeIcon(path: string): SVGSVGElement {
  const svg = document.createElementNS(SVG, 'svg'),
    shape = document.createElementNS(SVG, 'path');
  for (const [name, value] of Object.entries({
    viewBox: '0 0 16 16',
    width: '16',
    height: '16',
    'aria-hidden': 'true',
    class: 'icon',
  }))
    svg.setAttribute(name, value);
  shape.setAttribute('d', path);
  svg.append(shape);
  return svg;
}

export function get<T extends HTMLElement = HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export function button(
  text: string,
  act: () => void,
  attributes: Record<string, string | number | boolean> = {},
): HTMLButtonElement {
  const made = make('button', { type: 'button', ...attributes }, text);
  made.addEventListener('click', act);
  return made;
}

// A check box with its label.
export function check(text: string, isOn: boolean, change: (isOn: boolean) => void, ...after: Child[]): HTMLLabelElement {
  const input = make('input', { type: 'checkbox', checked: isOn });
  input.addEventListener('change', () => change(input.checked));
  return make('label', { class: 'check' }, input, make('span', {}, text), ...after);
}

export function choose(
  label: string,
  options: readonly (readonly [string, string])[],
  value: string,
  change: (value: string) => void,
): HTMLLabelElement {
  const select = make(
    'select',
    { 'aria-label': label },
    ...options.map(([key, text]) => make('option', { value: key, selected: key === value }, text)),
  );
  select.addEventListener('change', () => change(select.value));
  return make('label', { class: 'field' }, make('span', {}, label), select);
}

// "0.0123", "1.2e-5", with a minus that is as wide as a plus.
export function write(value: number | null | undefined, digits = 3): string {
  if (value === null || value === undefined || Number.isNaN(value)) return '\u2013';
  if (!Number.isFinite(value)) return value > 0 ? '\u221e' : '\u2212\u221e';
  return Number(value.toPrecision(digits)).toString().replaceAll('-', '\u2212');
}

export const writeVector = (vector: readonly number[] | undefined, digits = 4): string =>
  vector ? vector.map((part) => write(part, digits)).join(', ') : '\u2013';

export function download(name: string, data: Blob): void {
  const url = URL.createObjectURL(data),
    link = make('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

export const wantsLittleMotion = matchMedia('(prefers-reduced-motion: reduce)');
export const isDark = matchMedia('(prefers-color-scheme: dark)');
