// The scene with its lights and camera, drawn when something has changed and only while it is in view: a page of many viewers
// holds few WebGL contexts, of which browsers have some sixteen.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { chooseColor } from '../../../web/src/color.ts';
import { isInView } from '../../../web/src/in_view.ts';
import { Surface } from './surface.js';

const BACKGROUND = 0xf3f5f7;
const DIRECTION = new THREE.Vector3(0.55, -1, 0.62).normalize(); // from what is looked at to the camera
const MARGIN = 1.1; // room around what is shown

export function canDraw() {
  return Boolean(document.createElement('canvas').getContext('webgl2'));
}

function findBox(bodies) {
  const box = new THREE.Box3();
  for (const body of bodies) {
    box.expandByPoint(new THREE.Vector3(...body.low));
    box.expandByPoint(new THREE.Vector3(...body.low.map((low, axis) => low + 65535 * body.step[axis])));
  }
  return box;
}

// The bodies that the view must show: cloth, and the obstacles near it that are of its size; else all.
function chooseShown(bodies) {
  const cloth = findBox(bodies.filter((body) => body.kind !== 'obstacle'));
  return bodies.filter((body) => body.kind !== 'obstacle' || isInView(cloth, findBox([body])));
}

// Some of the places that bodies take in all their frames.
function sampleFrames(bodies) {
  const points = [];
  for (const body of bodies)
    for (let k = 0; k < Math.min(body.frameCount, 12); k++) {
      const frame = body.frameCount > 12 ? Math.round((k * (body.frameCount - 1)) / 11) : k;
      const stride = Math.max(1, Math.floor(body.vertexCount / 400));
      for (let i = 0; i < body.vertexCount; i += stride)
        points.push(new THREE.Vector3(body.get(frame, i, 0), body.get(frame, i, 1), body.get(frame, i, 2)));
    }
  return points;
}

export class Stage {
  constructor(view, film) {
    this.view = view;
    this.frame = 0;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(BACKGROUND);
    const counts = {};
    this.surfaces = film.bodies.map((body) => {
      const kind = body.kind === 'obstacle' ? 'obstacle' : 'cloth';
      counts[kind] = (counts[kind] ?? -1) + 1;
      return new Surface(body, chooseColor(kind, counts[kind]), film.scale);
    });
    for (const surface of this.surfaces) this.scene.add(surface.mesh);
    const shown = chooseShown(film.bodies);
    this.sphere = findBox(shown).getBoundingSphere(new THREE.Sphere());
    if (!(this.sphere.radius > 0)) this.sphere.set(new THREE.Vector3(), 1);
    this.points = sampleFrames(shown);
    this.camera = new THREE.PerspectiveCamera(32, 1, this.sphere.radius * 0.01, this.sphere.radius * 60);
    this.camera.up.set(0, 0, 1);
    this.addLights();
    this.controls = new OrbitControls(this.camera, view);
    this.controls.addEventListener('change', () => this.ask());
    this.controls.addEventListener('start', () => (this.isReset = false));
    this.controls.zoomToCursor = true;
    // A page scrolls past a view that has not the focus, by wheel and by finger.
    this.controls.enableZoom = false;
    view.style.touchAction = 'pan-y';
    view.addEventListener('pointerdown', () => view.focus({ preventScroll: true }));
    view.addEventListener('focus', () => (this.controls.enableZoom = true));
    view.addEventListener('blur', () => (this.controls.enableZoom = false));
    new ResizeObserver(() => this.resize()).observe(view);
    new IntersectionObserver(([entry]) => {
      this.isInView = entry.isIntersecting;
      this.isInView ? this.open() : this.close();
    }).observe(view);
    this.reset();
  }

  addLights() {
    const { center, radius } = this.sphere;
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0xb8bcc4, 1.5));
    const key = new THREE.DirectionalLight(0xfff6e8, 2.1);
    key.position.copy(center).addScaledVector(new THREE.Vector3(-0.5, -0.45, 1).normalize(), 4 * radius);
    key.target.position.copy(center);
    key.castShadow = true;
    key.shadow.mapSize.set(1024, 1024);
    key.shadow.normalBias = radius * 0.01;
    key.shadow.intensity = 0.6;
    Object.assign(key.shadow.camera, { left: -radius, right: radius, top: radius, bottom: -radius, near: radius, far: 8 * radius });
    this.scene.add(key, key.target);
  }

  // The view that shows everything.
  reset() {
    const up = Math.tan((this.camera.fov * Math.PI) / 360), across = up * this.camera.aspect;
    const right = new THREE.Vector3().crossVectors(this.camera.up, DIRECTION).normalize();
    const above = new THREE.Vector3().crossVectors(DIRECTION, right);
    const place = new THREE.Vector3();
    let distance = 0.2 * this.sphere.radius;
    for (const point of this.points) {
      place.subVectors(point, this.sphere.center);
      const room = Math.max(Math.abs(place.dot(right)) / across, Math.abs(place.dot(above)) / up);
      distance = Math.max(distance, place.dot(DIRECTION) + MARGIN * room);
    }
    this.controls.target.copy(this.sphere.center);
    this.camera.position.copy(this.sphere.center).addScaledVector(DIRECTION, distance);
    this.controls.update();
    this.isReset = true;
    this.ask();
  }

  // Turns the camera about what it looks at by angles, or goes nearer by a factor.
  turn(across, up, nearer = 1) {
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(new THREE.Quaternion().setFromUnitVectors(
      this.camera.up, new THREE.Vector3(0, 1, 0)));
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta += across;
    place.phi = Math.min(Math.max(place.phi - up, 0.01), Math.PI - 0.01);
    place.radius *= nearer;
    this.isReset = false;
    offset.setFromSpherical(place).applyQuaternion(new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), this.camera.up));
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  setFrame(frame) {
    this.frame = frame;
    this.ask();
  }

  setEdges(isShown) {
    for (const surface of this.surfaces) surface.setEdges(isShown);
    this.ask();
  }

  open() {
    if (this.renderer) return;
    const renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: 'low-power' });
    renderer.shadowMap.enabled = true;
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.domElement.setAttribute('aria-hidden', 'true');
    renderer.domElement.addEventListener('webglcontextlost', () => {
      if (renderer !== this.renderer) return; // it was closed
      this.close();
      setTimeout(() => this.isInView && this.open(), 1000);
    });
    this.view.prepend(renderer.domElement);
    this.renderer = renderer;
    this.resize();
  }

  close() {
    if (!this.renderer) return;
    const renderer = this.renderer;
    this.renderer = null;
    for (const surface of this.surfaces) surface.release();
    renderer.dispose();
    renderer.forceContextLoss();
    renderer.domElement.remove();
    delete this.view.dataset.drawn;
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.view;
    if (!width || !height) return;
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.renderer?.setSize(width, height);
    if (this.isReset) this.reset();
    this.ask();
  }

  // Draws before the next picture of the browser, once.
  ask() {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame(() => {
      this.isAsked = false;
      this.draw();
    });
  }

  draw() {
    if (!this.renderer) return;
    for (const surface of this.surfaces) surface.setFrame(this.frame);
    this.renderer.render(this.scene, this.camera);
    this.view.dataset.drawn = this.frame;
  }
}
