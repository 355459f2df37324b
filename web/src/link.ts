// A link to a view: the fragment of the address holds the frame, the camera, the overlays, the look and what is chosen.
import type { Selection } from './pick.ts';
import type { Look } from './surface.ts';

export interface ViewLink {
  frame?: number;
  camera?: number[];
  overlays?: string[];
  look?: Partial<Look> & { hasGround?: boolean };
  selection?: Selection;
}

export function writeLink(link: ViewLink): string {
  const parts = new URLSearchParams();
  if (link.frame !== undefined) parts.set('frame', String(link.frame));
  if (link.camera) parts.set('camera', link.camera.join(','));
  if (link.overlays?.length) parts.set('overlays', link.overlays.join(','));
  const { look } = link,
    words: string[] = [];
  if (look?.shading === 'flat') words.push('flat');
  if (look?.texture === 'checker') words.push('checker');
  if (look?.hasWires) words.push('wires');
  if (look && look.hasShadows === false) words.push('no-shadows');
  if (look && look.hasGround === false) words.push('no-ground');
  if (words.length) parts.set('look', words.join(','));
  if (link.selection) {
    const { object, triangle, weights, part } = link.selection;
    parts.set('selection', [object, triangle, ...weights.map((weight) => Number(weight.toFixed(4))), part].join(','));
  }
  return parts.toString().replaceAll('%2C', ',');
}

export function readLink(fragment: string): ViewLink {
  const parts = new URLSearchParams(fragment.replace(/^#/, '')),
    link: ViewLink = {};
  const frame = Number(parts.get('frame') ?? NaN);
  if (Number.isInteger(frame) && frame >= 0) link.frame = frame;
  const camera = parts.get('camera')?.split(',').map(Number);
  if (camera?.length === 6 && camera.every(Number.isFinite)) link.camera = camera;
  const overlays = parts.get('overlays');
  if (overlays) link.overlays = overlays.split(',');
  const words = parts.get('look')?.split(',');
  if (words)
    link.look = {
      shading: words.includes('flat') ? 'flat' : 'smooth',
      texture: words.includes('checker') ? 'checker' : 'plain',
      hasWires: words.includes('wires'),
      hasShadows: !words.includes('no-shadows'),
      hasGround: !words.includes('no-ground'),
    };
  const chosen = parts.get('selection')?.split(','),
    numbers = chosen?.slice(0, 5).map(Number);
  if (chosen?.length === 6 && numbers!.every(Number.isFinite) && ['vertex', 'edge', 'triangle'].includes(chosen[5])) {
    const [object, triangle, ...weights] = numbers!;
    link.selection = { object, triangle, weights: weights as [number, number, number], part: chosen[5] as Selection['part'] };
  }
  return link;
}
