// The scene with its lights, drawn when something has changed and not otherwise.
import * as THREE from 'three';
import { ViewCamera } from './camera.ts';
import { isDark, make } from './dom.ts';
import { isInView } from './in_view.ts';
import type { Look, Surface } from './surface.ts';

export function canDraw(): boolean {
  return Boolean(document.createElement('canvas').getContext('webgl2'));
}

const SLOW = 60,
  REST = 600; // milliseconds: from here on it is coarse; without a change for so long it is sharp again

function drawsBySoftware(): boolean {
  const context = document.createElement('canvas').getContext('webgl2'),
    names = context?.getExtension('WEBGL_debug_renderer_info');
  const name = context && names ? String(context.getParameter(names.UNMASKED_RENDERER_WEBGL)) : '';
  context?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software/i.test(name);
}

export interface Counts {
  drawn: number;
  isSoftware: boolean;
  received: number;
}

export class Stage {
  readonly view: HTMLElement;
  readonly scene = new THREE.Scene();
  readonly camera: ViewCamera;
  readonly canvas: HTMLCanvasElement;
  readonly marks = new THREE.Group(); // overlays, the selection, a grab
  surfaces: Surface[] = [];
  drawn = 0; // pictures since the start
  beforeDraw: () => void = () => {};
  afterDraw: () => void = () => {};
  private readonly renderer: THREE.WebGLRenderer;
  private readonly key = new THREE.DirectionalLight(0xfff6e8, 2.2);
  private readonly sky = new THREE.HemisphereLight(0xffffff, 0xb8bcc4, 1.6);
  private readonly ground: THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial>;
  private readonly shade: THREE.Mesh<THREE.PlaneGeometry, THREE.ShadowMaterial>;
  private look: Look = { shading: 'smooth', texture: 'plain', hasWires: false, hasShadows: true };
  private isAsked = false;
  readonly isSoftware: boolean; // the processor draws, not a graphics card
  private readonly sharpness = Math.min(window.devicePixelRatio, 2);
  mustBeSharp = false; // while a film is made
  private isCoarse = false; // fewer pixels while pictures change faster than they can be drawn
  private lastDraw = 0;
  private pace = 0; // milliseconds from one picture to the next, while they change
  private rest = 0;
  private up = new THREE.Vector3(0, 0, 1);

  constructor(view: HTMLElement) {
    this.view = view;
    this.isSoftware = drawsBySoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.isSoftware, preserveDrawingBuffer: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.setPixelRatio(this.sharpness);
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute('aria-hidden', 'true');
    view.prepend(this.canvas);
    this.camera = new ViewCamera(view, () => this.ask());
    this.ground = makeGround();
    this.shade = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), new THREE.ShadowMaterial({ opacity: 0.22 }));
    this.shade.receiveShadow = true;
    this.key.castShadow = true;
    this.key.shadow.mapSize.setScalar(this.isSoftware ? 1024 : 2048);
    this.key.shadow.intensity = 0.6;
    // A weak light goes along with the camera, so nothing that is looked at is black.
    this.camera.camera.add(new THREE.DirectionalLight(0xffffff, 0.7));
    this.scene.add(this.camera.camera, this.sky, this.key, this.key.target, this.ground, this.shade, this.marks);
    new ResizeObserver(() => this.resize()).observe(view);
    isDark.addEventListener('change', () => this.setTheme());
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.ask());
    this.setTheme();
    this.resize();
  }

  private setTheme(): void {
    this.scene.background = new THREE.Color(isDark.matches ? 0x23282f : 0xeef1f4);
    const { lines, floor } = this.ground.material.uniforms;
    (lines.value as THREE.Color).set(isDark.matches ? 0x5a6573 : 0xa3adb9);
    (floor.value as THREE.Color).set(isDark.matches ? 0x23282f : 0xeef1f4);
    this.shade.material.opacity = isDark.matches ? 0.4 : 0.22;
    this.ask();
  }

  setSurfaces(surfaces: Surface[], up: THREE.Vector3, box: THREE.Box3): void {
    for (const surface of this.surfaces) surface.dispose();
    this.surfaces = surfaces;
    this.up = up;
    for (const surface of surfaces) {
      surface.setLook(this.look);
      this.scene.add(surface.group);
    }
    const { center, radius } = box.getBoundingSphere(new THREE.Sphere());
    const room = Math.max(radius, 1e-3);
    this.camera.setScene(up, room);
    this.sky.position.copy(up);
    const aside = new THREE.Vector3(-0.5, -0.45, 0.35);
    aside.addScaledVector(up, 1.1 - aside.dot(up)).normalize();
    this.key.position.copy(center).addScaledVector(aside, 4 * room);
    this.key.target.position.copy(center);
    this.key.shadow.normalBias = room * 0.006;
    const reach = 1.3 * room;
    Object.assign(this.key.shadow.camera, {
      left: -reach,
      right: reach,
      top: reach,
      bottom: -reach,
      near: room,
      far: 8 * room,
    });
    this.key.shadow.camera.updateProjectionMatrix();
    // The ground lies under everything, a hair lower, so that an obstacle there is not drawn through it.
    const low = Math.min(...[box.min, box.max].map((corner) => corner.dot(up))),
      away = low - center.dot(up) - 0.004 * room;
    for (const part of [this.ground, this.shade]) {
      part.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
      part.position.copy(center).addScaledVector(up, away);
      part.scale.setScalar(16 * room);
    }
    this.shade.position.addScaledVector(up, 0.0005 * room);
    this.ground.material.uniforms.cell.value = 10 ** Math.round(Math.log10(room / 4));
    this.ground.material.uniforms.reach.value = 6 * room;
    (this.ground.material.uniforms.middle.value as THREE.Vector3).copy(this.ground.position);
    this.ask();
  }

  setLook(look: Look, hasGround: boolean): void {
    this.look = look;
    this.renderer.shadowMap.enabled = look.hasShadows;
    this.key.castShadow = look.hasShadows;
    this.ground.visible = hasGround;
    this.shade.visible = hasGround && look.hasShadows;
    for (const surface of this.surfaces) surface.setLook(look);
    this.ask();
  }

  // The box of some surfaces, or of cloth and bodies with what is near them and of their size.
  findBox(surfaces?: readonly Surface[]): THREE.Box3 {
    const box = new THREE.Box3(),
      shown = this.surfaces.filter((surface) => surface.group.visible);
    if (surfaces) {
      for (const surface of surfaces) surface.growBox(box);
      return box;
    }
    for (const surface of shown) if (surface.info.role !== 'obstacle') surface.growBox(box);
    const watched = box.clone();
    for (const surface of shown) {
      const own = new THREE.Box3();
      surface.growBox(own);
      if (isInView(watched, own)) box.union(own);
    }
    return box;
  }

  getUp(): THREE.Vector3 {
    return this.up;
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.view;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.resize(width, height);
    // A canvas that was resized is blank until it is drawn.
    this.draw();
  }

  // Draws before the next picture of the browser, once.
  ask(): void {
    if (this.isAsked) return;
    this.isAsked = true;
    requestAnimationFrame((now) => {
      this.isAsked = false;
      this.keepPace(now);
      this.draw();
    });
  }

  // Draws fewer pixels while it cannot keep up, and all of them once it is at rest.
  private keepPace(now: number): void {
    const gap = now - this.lastDraw;
    this.lastDraw = now;
    if (gap < REST) this.pace += 0.25 * (gap - this.pace);
    clearTimeout(this.rest);
    if (this.pace > SLOW && !this.isCoarse && !this.mustBeSharp) this.setCoarse(true);
    if (this.isCoarse)
      this.rest = window.setTimeout(() => {
        this.pace = 0;
        this.setCoarse(false);
      }, REST);
  }

  setCoarse(isCoarse: boolean): void {
    this.isCoarse = isCoarse;
    this.view.toggleAttribute('data-coarse', isCoarse);
    this.renderer.setPixelRatio(isCoarse ? this.sharpness / 2 : this.sharpness);
    if (!isCoarse) this.draw();
  }

  draw(): void {
    this.beforeDraw();
    for (const surface of this.surfaces) surface.update();
    this.camera.update();
    this.renderer.render(this.scene, this.camera.camera);
    this.drawn++;
    this.afterDraw();
  }

  // Waits until the picture is drawn, and not only asked for.
  finish(): void {
    const context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // The picture as a file, with legends under it left out: they are words of the page.
  async takePicture(): Promise<Blob> {
    this.setCoarse(false);
    return new Promise((done, fail) =>
      this.canvas.toBlob((blob) => (blob ? done(blob) : fail(new Error('the browser made no picture'))), 'image/png'),
    );
  }
}

// A plane with a grid of square cells that fades out.
function makeGround(): THREE.Mesh<THREE.PlaneGeometry, THREE.ShaderMaterial> {
  const material = new THREE.ShaderMaterial({
    transparent: true,
    depthWrite: false,
    side: THREE.FrontSide,
    uniforms: {
      lines: { value: new THREE.Color() },
      floor: { value: new THREE.Color() },
      cell: { value: 1 },
      reach: { value: 1 },
      middle: { value: new THREE.Vector3() },
    },
    vertexShader: `varying vec2 place; uniform float reach;
      void main() {
        place = position.xy * (16.0 / 6.0) * reach;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
      }`,
    fragmentShader: `uniform vec3 lines; uniform vec3 floor; uniform float cell, reach; varying vec2 place;
      float draw(float size) {
        vec2 at = place / size, edge = abs(fract(at - 0.5) - 0.5) / fwidth(at);
        return 1.0 - min(min(edge.x, edge.y), 1.0);
      }
      void main() {
        float fade = 1.0 - smoothstep(0.25, 1.0, length(place) / reach);
        float line = max(0.35 * draw(cell), 0.8 * draw(10.0 * cell));
        gl_FragColor = vec4(lines, line * fade);
        #include <colorspace_fragment>
      }`,
  });
  const ground = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), material);
  ground.renderOrder = -1;
  return ground;
}

// "58 drawn, 60 received a second", in a corner.
export class Corner {
  readonly element = make('p', { class: 'corner', hidden: true, 'data-testid': 'counts' });
  private last = performance.now();
  private drawn = 0;
  private received = 0;

  constructor(private readonly read: () => Counts) {
    window.setInterval(() => this.write(), 1000);
  }

  toggle(isShown: boolean): void {
    this.element.hidden = !isShown;
    this.write();
  }

  private write(): void {
    const now = performance.now(),
      counts = this.read(),
      seconds = (now - this.last) / 1000;
    if (seconds < 0.2) return;
    const drawn = (counts.drawn - this.drawn) / seconds,
      received = (counts.received - this.received) / seconds;
    this.element.textContent = `${drawn.toFixed(0)} drawn${counts.isSoftware ? ' by software' : ''}, ${received.toFixed(0)} received a second`;
    Object.assign(this.element.dataset, { drawn: drawn.toFixed(2), received: received.toFixed(2) });
    Object.assign(this, { last: now, drawn: counts.drawn, received: counts.received });
  }
}
