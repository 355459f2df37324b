// Where a rigid object is. Frames tell the places of its vertices.
import * as THREE from 'three';
import type { Surface } from './surface.ts';

// The turn of a rigid mesh since its first place, and where a point of it is now, by three of its vertices.
export function findPose(surface: Surface, point: THREE.Vector3): { position: THREE.Vector3; rotation: THREE.Quaternion } {
  const x = surface.mesh.positions,
    count = surface.mesh.vertexCount;
  const rest = (i: number) => new THREE.Vector3().fromArray(x, 3 * i);
  const frame = (a: THREE.Vector3, b: THREE.Vector3, c: THREE.Vector3) => {
    const e = b.clone().sub(a).normalize(),
      n = e.clone().cross(c.clone().sub(a)).normalize();
    return new THREE.Matrix4().makeBasis(e, n.clone().cross(e), n);
  };
  // A far vertex from the first, then the one farthest from the line through both.
  const first = rest(0);
  let far = 0,
    third = 0,
    best = -1;
  for (let i = 0; i < count; i++) {
    const distance = rest(i).distanceToSquared(first);
    if (distance > best) [best, far] = [distance, i];
  }
  const line = rest(far).sub(first).normalize();
  best = -1;
  for (let i = 0; i < count; i++) {
    const distance = rest(i).sub(first).cross(line).lengthSq();
    if (distance > best) [best, third] = [distance, i];
  }
  const before = frame(first, rest(far), rest(third));
  const now = [0, far, third].map((i) => surface.getVertex(i));
  const turn = frame(now[0], now[1], now[2]).multiply(before.transpose()),
    rotation = new THREE.Quaternion().setFromRotationMatrix(turn);
  return { position: point.clone().sub(first).applyQuaternion(rotation).add(now[0]), rotation };
}
