// Colors by lightness, chroma and hue, and the maps of values: those of `tulle render` (src/render/color_map.c says why).
// Based on: B. Ottosson, "A perceptual color space for image processing", 2020.

export type Color = [number, number, number];

// Linear RGB.
export function fromOklch([lightness, chroma, hue]: Color): Color {
  const a = chroma * Math.cos((hue * Math.PI) / 180),
    b = chroma * Math.sin((hue * Math.PI) / 180);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ].map((part) => Math.min(Math.max(part, 0), 1)) as Color;
}

const SEQUENTIAL_CHROMA = [0.085, 0.125, 0.13, 0.115, 0.098, 0.094, 0.105, 0.13, 0.155, 0.17, 0.165];

export type ColorMap = 'sequential' | 'diverging';

// Linear RGB of a value in 0 .. 1.
export function mapValue(map: ColorMap, value: number): Color {
  if (map === 'diverging') {
    const distance = Math.abs(2 * value - 1);
    const chroma = 0.165 * distance * (1.9 - 0.9 * distance) * (0.72 + 0.28 * distance);
    return fromOklch([0.93 - 0.45 * distance, chroma, value < 0.5 ? 260 : 27]);
  }
  const place = value * (SEQUENTIAL_CHROMA.length - 1);
  const step = Math.min(Math.floor(place), SEQUENTIAL_CHROMA.length - 2);
  const chroma = SEQUENTIAL_CHROMA[step] + (place - step) * (SEQUENTIAL_CHROMA[step + 1] - SEQUENTIAL_CHROMA[step]);
  return fromOklch([0.27 + 0.65 * value, chroma, 308 - 202 * value]);
}

export function toCss(rgb: Color): string {
  const encode = (part: number) => (part <= 0.0031308 ? 12.92 * part : 1.055 * part ** (1 / 2.4) - 0.055);
  return `rgb(${rgb.map((part) => Math.round(255 * encode(part))).join(' ')})`;
}

const CLOTHS: Color[] = [
  [0.68, 0.12, 234],
  [0.76, 0.14, 75],
  [0.66, 0.15, 20],
  [0.7, 0.12, 150],
  [0.64, 0.14, 300],
  [0.72, 0.13, 340],
];
const OBSTACLE: Color = [0.82, 0.012, 250];

// Linear RGB of body `index` of its kind.
export function chooseColor(kind: string, index: number): Color {
  return fromOklch(kind === 'obstacle' ? OBSTACLE : CLOTHS[index % CLOTHS.length]);
}
