// Which bodies a view shows whole beside the cloth: those near it that are of its size, as in pictures of `tulle render` (picture_view_add_obstacle
// in src/app/render/camera.c). Ground of many metres makes no cloth tiny.
import * as THREE from 'three';

const NEAR = 0.15, // of the cloth's diagonal: how far around it counts
  SIZE = 1.6; // times the cloth's diagonal: up to there a body is shown whole

const measure = (box: THREE.Box3): number => box.getSize(new THREE.Vector3()).length();

// Without cloth everything is shown.
export function isInView(cloth: THREE.Box3, body: THREE.Box3): boolean {
  if (cloth.isEmpty()) return true;
  const diagonal = measure(cloth);
  return measure(body) <= SIZE * diagonal && cloth.clone().expandByScalar(NEAR * diagonal).intersectsBox(body);
}
