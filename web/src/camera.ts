// The camera: by mouse and finger through three's OrbitControls, by keys, along axes, and as numbers for links.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { wantsLittleMotion } from './dom.ts';

const MARGIN = 1.12; // room around what is framed
const FIELD_OF_VIEW = 31.5; // degrees, that of `tulle render`
const WIDE = 1.5; // pictures of scenes are about so wide for their height
const FLIGHT = 220; // milliseconds from one view to the next

export class ViewCamera {
  readonly camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01, 100);
  controls: OrbitControls;
  private readonly element: HTMLElement;
  private readonly ask: () => void;
  private flight = 0;
  private arrive: (() => void) | null = null; // to where a flight leads
  private size = 1; // of the scene [m]
  private framed: (() => void) | null = null; // frames again what the view shows, as long as nobody turned it

  constructor(element: HTMLElement, ask: () => void) {
    this.element = element;
    this.ask = ask;
    this.controls = this.makeControls();
  }

  // They take the direction upwards when they are made.
  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.element);
    controls.zoomToCursor = true;
    controls.addEventListener('change', this.ask);
    controls.addEventListener('start', () => {
      cancelAnimationFrame(this.flight);
      this.arrive = this.framed = null;
    });
    return controls;
  }

  // `up` turns the scene so that this axis points upwards.
  setScene(up: THREE.Vector3, size: number): void {
    this.size = size;
    this.camera.up.copy(up);
    const target = this.controls.target.clone();
    this.controls.dispose();
    this.controls = this.makeControls();
    this.controls.target.copy(target);
    this.controls.minDistance = size * 0.002;
    this.controls.maxDistance = size * 40;
    this.updateRange();
  }

  // Ends a flight where it leads to.
  private leave(): void {
    cancelAnimationFrame(this.flight);
    this.arrive?.();
    this.arrive = this.framed = null;
  }

  resize(width: number, height: number): void {
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    this.framed?.();
    this.ask();
  }

  private updateRange(): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.camera.near = Math.max(distance * 0.004, this.size * 1e-4);
    this.camera.far = distance + this.size * 20;
    this.camera.updateProjectionMatrix();
  }

  // Called before drawing.
  update(): void {
    this.updateRange();
  }

  // To a place, in a short flight unless little motion is wanted.
  private fly(position: THREE.Vector3, target: THREE.Vector3, isQuick = false): void {
    const from = this.camera.position.clone(),
      fromTarget = this.controls.target.clone(),
      start = performance.now();
    const place = (part: number) => {
      this.controls.target.lerpVectors(fromTarget, target, part);
      // Round about the target rather than through it.
      const a = from.clone().sub(fromTarget),
        b = position.clone().sub(target);
      const direction = a.clone().normalize().lerp(b.clone().normalize(), part);
      if (direction.lengthSq() < 1e-3) direction.copy(b);
      this.camera.position
        .copy(this.controls.target)
        .addScaledVector(direction.normalize(), a.length() + (b.length() - a.length()) * part);
      this.controls.update();
      this.ask();
    };
    if (isQuick || wantsLittleMotion.matches) return place(1);
    this.arrive = () => place(1);
    const step = () => {
      const part = Math.min((performance.now() - start) / FLIGHT, 1);
      place(part * part * (3 - 2 * part));
      if (part < 1) this.flight = requestAnimationFrame(step);
      else this.arrive = null;
    };
    step();
  }

  // Shows a box from where the camera is, or from `direction`.
  frame(box: THREE.Box3, direction?: THREE.Vector3, isQuick = false): void {
    if (box.isEmpty()) return;
    this.leave();
    const center = box.getCenter(new THREE.Vector3()),
      { min, max } = box;
    const from = (direction ?? this.camera.position.clone().sub(this.controls.target)).clone().normalize();
    const right = new THREE.Vector3().crossVectors(this.camera.up, from);
    if (right.lengthSq() < 1e-6) right.set(1, 0, 0).cross(this.camera.up).cross(this.camera.up).negate();
    if (right.lengthSq() < 1e-6) right.set(0, 1, 0);
    right.normalize();
    const above = new THREE.Vector3().crossVectors(from, right);
    const up = Math.tan((this.camera.fov * Math.PI) / 360),
      across = up * this.camera.aspect,
      corner = new THREE.Vector3();
    let distance = Math.max(box.getSize(corner).length() * 0.05, this.size * 0.005);
    for (let k = 0; k < 8; k++) {
      corner.set(k & 1 ? max.x : min.x, k & 2 ? max.y : min.y, k & 4 ? max.z : min.z).sub(center);
      const room = Math.max(Math.abs(corner.dot(right)) / across, Math.abs(corner.dot(above)) / up);
      distance = Math.max(distance, corner.dot(from) + MARGIN * room);
    }
    this.fly(center.clone().addScaledVector(from, distance), center, isQuick);
    this.framed = () => this.frame(box, from, true);
  }

  // As a scene has it; farther away where the picture is narrow.
  takePlace(position: THREE.Vector3, target: THREE.Vector3, fieldOfView?: number): void {
    this.leave();
    if (fieldOfView) this.camera.fov = (180 * fieldOfView) / Math.PI;
    const way = position
      .clone()
      .sub(target)
      .multiplyScalar(Math.max(1, WIDE / this.camera.aspect));
    this.fly(target.clone().add(way), target, true);
    this.framed = () => this.takePlace(position, target);
  }

  // From the side of an axis: 'x', '-x', 'y' ... The axis that points upwards is seen from a hair beside it.
  lookAlong(axis: string): void {
    this.leave();
    const direction = new THREE.Vector3();
    direction.setComponent('xyz'.indexOf(axis.at(-1)!), axis.startsWith('-') ? -1 : 1);
    if (Math.abs(direction.dot(this.camera.up)) > 0.99) {
      const aside = Math.abs(this.camera.up.z) > 0.5 ? new THREE.Vector3(0, -1, 0) : new THREE.Vector3(0, 0, 1);
      direction.addScaledVector(aside, 1e-3).normalize();
    }
    const distance = this.camera.position.distanceTo(this.controls.target);
    this.fly(this.controls.target.clone().addScaledVector(direction, distance), this.controls.target.clone());
  }

  // Turns about the target by angles, or goes nearer by a factor.
  turn(across: number, up: number, nearer = 1): void {
    this.leave();
    const level = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    const place = new THREE.Spherical().setFromVector3(
      this.camera.position.clone().sub(this.controls.target).applyQuaternion(level),
    );
    place.theta += across;
    place.phi = Math.min(Math.max(place.phi - up, 0.001), Math.PI - 0.001);
    place.radius = Math.min(Math.max(place.radius * nearer, this.controls.minDistance), this.controls.maxDistance);
    this.camera.position.setFromSpherical(place).applyQuaternion(level.invert()).add(this.controls.target);
    this.controls.update();
    this.ask();
  }

  // Moves sideways and upwards by shares of the height of the picture.
  pan(across: number, up: number): void {
    this.leave();
    const height = 2 * Math.tan((this.camera.fov * Math.PI) / 360) * this.camera.position.distanceTo(this.controls.target);
    const [right, above] = this.getAxes();
    const way = right.multiplyScalar(across * height).addScaledVector(above, up * height);
    this.camera.position.add(way);
    this.controls.target.add(way);
    this.controls.update();
    this.ask();
  }

  // The directions to the right, upwards and towards the camera in the picture.
  getAxes(): [THREE.Vector3, THREE.Vector3, THREE.Vector3] {
    const axes: [THREE.Vector3, THREE.Vector3, THREE.Vector3] = [new THREE.Vector3(), new THREE.Vector3(), new THREE.Vector3()];
    this.camera.updateMatrixWorld();
    this.camera.matrixWorld.extractBasis(...axes);
    return axes;
  }

  // Metres that one pixel covers at a distance.
  getPixel(point: THREE.Vector3, height: number): number {
    const depth = this.getAxes()[2].dot(this.camera.position.clone().sub(point));
    return (2 * Math.tan((this.camera.fov * Math.PI) / 360) * depth) / height;
  }

  toNumbers(): number[] {
    return [...this.camera.position.toArray(), ...this.controls.target.toArray()].map((part) => Number(part.toPrecision(6)));
  }

  setNumbers(numbers: readonly number[]): void {
    if (numbers.length !== 6 || !numbers.every(Number.isFinite)) return;
    this.leave();
    this.camera.position.fromArray(numbers, 0);
    this.controls.target.fromArray(numbers, 3);
    this.controls.update();
    this.ask();
  }
}
