// Taking hold of a live scene: cloth and bodies are pulled by a point in the plane that faces the camera, by mouse, finger or keys; obstacles and
// bodies are moved by three's TransformControls or by numbers.
import * as THREE from 'three';
import { TransformControls } from 'three/examples/jsm/controls/TransformControls.js';
import type { Connection } from './connection.ts';
import { type Hit, type Picker, setLine } from './pick.ts';
import { findPose } from './pose.ts';
import type { Vector } from './protocol.ts';
import type { Stage } from './stage.ts';
import type { Surface } from './surface.ts';

export type Tool = 'look' | 'grab' | 'cut' | 'move';

const CLICK = 4; // pixels that a pointer may stray in a click
const PAUSE = 16; // milliseconds between messages of a drag: the newest place counts
const KEY_STEP = 0.02; // of the scene's size, moved by a key

interface Grab {
  object: number;
  triangle: number;
  weights: [number, number, number];
  target: THREE.Vector3;
  plane: THREE.Plane;
  id: number | null; // null: the server has not answered yet
  isOver: boolean; // let go before the answer came
  isSent: boolean; // the newest target went out
  byKeys: boolean;
}

export interface HoldOptions {
  stage: Stage;
  picker: Picker;
  connection: () => Connection;
  say: (words: string) => void;
  fail: (problem: unknown) => void;
  onChange: () => void;
}

const toVector = (point: THREE.Vector3): Vector => point.toArray() as Vector;

export class Hold {
  tool: Tool = 'look';
  force = 5; // largest force of a grab [N]
  isAble = false; // the scene is live
  moved: number | null = null; // the object that the arrows move
  private grab: Grab | null = null;
  private readonly o: HoldOptions;
  private readonly line: THREE.LineSegments<THREE.BufferGeometry, THREE.LineDashedMaterial>;
  private readonly ends: THREE.Points<THREE.BufferGeometry, THREE.PointsMaterial>;
  private readonly pinMarks = new THREE.Points(
    new THREE.BufferGeometry(),
    new THREE.PointsMaterial({ color: 0xd6006c, size: 8, sizeAttenuation: false, depthTest: false }),
  );
  private pinned: { surface: Surface; vertex: number }[] = [];
  private readonly gizmo: TransformControls;
  private readonly pivot = new THREE.Object3D();
  private readonly middle = new THREE.Vector3(); // of the box of the moved object's mesh: it is moved by this point
  private wanted: { position: THREE.Vector3; rotation: THREE.Quaternion } | null = null; // a move that is to go out
  private sent = 0; // when a drag went out
  private missed = 0; // states that did not know the grab
  private press: { x: number; y: number; id: number } | null = null;
  private pointer = -1; // that drags the grab

  constructor(options: HoldOptions) {
    this.o = options;
    const { stage } = options;
    this.line = new THREE.LineSegments(
      new THREE.BufferGeometry(),
      new THREE.LineDashedMaterial({ color: 0xd6006c, depthTest: false, dashSize: 1, gapSize: 0 }),
    );
    this.ends = new THREE.Points(
      new THREE.BufferGeometry(),
      new THREE.PointsMaterial({ color: 0xd6006c, size: 10, sizeAttenuation: false, depthTest: false }),
    );
    for (const each of [this.line, this.ends, this.pinMarks]) {
      each.frustumCulled = false;
      each.visible = false;
      each.renderOrder = 10;
      stage.marks.add(each);
    }
    stage.scene.add(this.pivot);
    this.gizmo = new TransformControls(stage.camera.camera, stage.view);
    this.gizmo.addEventListener('change', () => stage.ask());
    this.gizmo.addEventListener('objectChange', () => this.sendPivot());
    this.gizmo.addEventListener('dragging-changed', ({ value }) => (stage.camera.controls.enabled = !value));
    stage.scene.add(this.gizmo.getHelper());
    const { view } = stage;
    view.addEventListener('pointerdown', (event) => this.onDown(event), true);
    view.addEventListener('pointermove', (event) => this.onMove(event), true);
    view.addEventListener('pointerup', (event) => this.onUp(event), true);
    view.addEventListener('pointercancel', (event) => this.onUp(event), true);
  }

  setTool(tool: Tool): void {
    this.tool = tool;
    this.o.stage.view.dataset.tool = tool;
    void this.showPins();
    if (tool !== 'move') this.detach();
    else this.attachTo(this.o.picker.selection?.object ?? null);
    this.o.onChange();
  }

  get isHolding(): boolean {
    return this.grab !== null;
  }

  get isByKeys(): boolean {
    return this.grab?.byKeys ?? false;
  }

  // ---- pointers ----

  private onDown(event: PointerEvent): void {
    if (event.target !== this.o.stage.canvas) return;
    this.o.stage.view.focus({ preventScroll: true });
    this.press = { x: event.clientX, y: event.clientY, id: event.pointerId };
    const wantsGrab = this.isAble && event.button === 0 && (this.tool === 'grab' || (event.shiftKey && this.tool === 'look'));
    if (!wantsGrab || this.grab) return;
    const hit = this.o.picker.find(event);
    if (!hit || this.o.stage.surfaces[hit.object].info.role === 'obstacle') return;
    event.stopPropagation();
    this.pointer = event.pointerId;
    this.o.stage.view.setPointerCapture(event.pointerId);
    this.begin(hit, false);
  }

  private onMove(event: PointerEvent): void {
    if (!this.grab || this.grab.byKeys || event.pointerId !== this.pointer) return;
    event.stopPropagation();
    const point = this.o.picker.getRay(event).intersectPlane(this.grab.plane, new THREE.Vector3());
    if (!point) return;
    this.grab.target.copy(point);
    this.grab.isSent = false;
    this.o.stage.ask();
  }

  private onUp(event: PointerEvent): void {
    const { press } = this;
    this.press = null;
    if (this.grab && !this.grab.byKeys && event.pointerId === this.pointer) {
      event.stopPropagation();
      this.letGo();
      return;
    }
    const isClick =
      press && press.id === event.pointerId && Math.hypot(event.clientX - press.x, event.clientY - press.y) < CLICK;
    if (!isClick || event.button !== 0 || event.type !== 'pointerup' || this.gizmo.dragging) return;
    this.click(event);
  }

  private click(event: PointerEvent): void {
    const hit = this.o.picker.find(event);
    if (!hit) return this.o.picker.select(null);
    this.o.picker.choose(hit);
    if (this.tool === 'cut') this.cut();
  }

  // ---- grabbing ----

  private begin(hit: Pick<Hit, 'object' | 'triangle' | 'weights' | 'point'>, byKeys: boolean): void {
    const facing = this.o.stage.camera.getAxes()[2];
    const grab: Grab = {
      object: hit.object,
      triangle: hit.triangle,
      weights: hit.weights,
      target: hit.point.clone(),
      id: null,
      isOver: false,
      isSent: true,
      plane: new THREE.Plane().setFromNormalAndCoplanarPoint(facing, hit.point),
      byKeys,
    };
    this.grab = grab;
    const { object, triangle, weights } = hit;
    this.o
      .connection()
      .ask<{ type: string; grab: number }>({
        type: 'grab',
        object,
        triangle,
        weights,
        point: toVector(hit.point),
        force: this.force,
      })
      .then((answer) => {
        grab.id = answer.grab;
        if (grab.isOver) this.o.connection().send({ type: 'let_go', grab: answer.grab });
      })
      .catch((problem) => {
        if (this.grab === grab) this.grab = null;
        this.o.fail(problem);
        this.o.stage.ask();
        this.o.onChange();
      });
    this.o.say(`${this.o.stage.surfaces[object].info.name} is held`);
    this.o.stage.ask();
    this.o.onChange();
  }

  // Takes hold of what is chosen; arrows move it then.
  grabSelection(): void {
    const { selection } = this.o.picker;
    if (!this.isAble || !selection || this.grab) return;
    const surface = this.o.stage.surfaces[selection.object],
      nearest = this.o.picker.getNearest();
    if (surface.info.role === 'obstacle' || !nearest) return this.o.say('an obstacle cannot be held: move it');
    const weights = selection.weights.slice() as [number, number, number];
    this.begin(
      { object: selection.object, triangle: selection.triangle, weights, point: surface.getPoint(selection.triangle, weights) },
      true,
    );
    this.o.stage.view.focus({ preventScroll: true });
  }

  // Moves the held point by steps to the right, upwards and towards the camera.
  nudge(right: number, up: number, nearer: number): void {
    if (!this.grab) return;
    const axes = this.o.stage.camera.getAxes(),
      step = KEY_STEP * this.o.stage.findBox().getSize(new THREE.Vector3()).length();
    [right, up, nearer].forEach((count, k) => this.grab!.target.addScaledVector(axes[k], count * step));
    this.grab.isSent = false;
    this.o.stage.ask();
  }

  letGo(): void {
    const { grab } = this;
    if (!grab) return;
    this.grab = null;
    this.sendDrag(grab, true);
    grab.isOver = true;
    if (grab.id !== null) this.o.connection().send({ type: 'let_go', grab: grab.id });
    this.o.say('let go');
    this.o.stage.ask();
    this.o.onChange();
  }

  private sendDrag(grab: Grab, isLast = false): void {
    const now = performance.now();
    if (grab.isSent || grab.id === null || (now - this.sent < PAUSE && !isLast)) return;
    this.sent = now;
    grab.isSent = true;
    this.o.connection().send({ type: 'drag', grab: grab.id, point: toVector(grab.target) });
  }

  // Before each picture: the newest target goes out, the line follows the cloth.
  update(): void {
    const { grab } = this;
    this.line.visible = this.ends.visible = grab !== null;
    if (grab) {
      this.sendDrag(grab);
      if (!grab.isSent) setTimeout(() => this.o.stage.ask(), PAUSE); // the newest place is still to go out
      const held = this.o.stage.surfaces[grab.object].getPoint(grab.triangle, grab.weights);
      setLine(this.line, [held, grab.target]);
      setLine(this.ends, [grab.target, held]);
    }
    this.markPins();
    this.followObject();
  }

  // The pins that are left, marked while they are to be cut.
  private async showPins(): Promise<void> {
    const { surfaces } = this.o.stage;
    this.pinned = [];
    if (this.isAble && this.tool === 'cut')
      for (const [object, { info }] of surfaces.entries()) {
        if (info.role !== 'cloth' || !info.pins) continue;
        try {
          const { pins } = await this.o.connection().ask<{ type: string; pins: number[][] }>({ type: 'pins', object });
          for (const vertex of new Set(pins.flat())) this.pinned.push({ surface: surfaces[object], vertex });
        } catch (problem) {
          this.o.fail(problem);
        }
      }
    this.o.stage.ask();
  }

  private markPins(): void {
    this.pinMarks.visible = this.tool === 'cut' && this.pinned.length > 0;
    if (this.pinMarks.visible)
      setLine(
        this.pinMarks,
        this.pinned.map(({ surface, vertex }) => surface.getVertex(vertex)),
      );
  }

  // The server tells what it holds. A reset or a rewind lets go; a state may be older than the grab.
  checkHeld(held: readonly number[]): void {
    const { grab } = this;
    this.missed = grab && grab.id !== null && !held.includes(grab.id) ? this.missed + 1 : 0;
    if (this.missed < 3) return;
    this.missed = 0;
    this.grab = null;
    this.o.say('let go');
    this.o.stage.ask();
    this.o.onChange();
  }

  // What is held is gone: the scene is another one, or the connection was lost.
  forget(): void {
    this.grab = null;
    this.pinned = [];
    this.detach();
    this.o.onChange();
  }

  cut(): void {
    const { selection } = this.o.picker,
      nearest = this.o.picker.getNearest();
    if (!this.isAble || !selection || !nearest) return;
    this.o
      .connection()
      .ask({ type: 'cut_pin', object: selection.object, vertex: nearest.vertex })
      .then(() => {
        this.o.picker.select(this.o.picker.selection); // it is told anew
        this.o.say(`the pin of vertex ${nearest.vertex} is cut`);
        return this.showPins();
      })
      .catch((problem) => this.o.fail(problem));
  }

  // ---- moving objects ----

  private detach(): void {
    this.moved = null;
    this.gizmo.detach();
    this.o.stage.camera.controls.enabled = true;
    this.o.stage.ask();
  }

  attachTo(object: number | null): void {
    const surface = object === null ? undefined : this.o.stage.surfaces[object];
    if (!surface || surface.info.role === 'cloth' || !this.isAble) {
      this.detach();
      if (this.isAble && this.tool === 'move') this.o.say('choose an obstacle or a body to move');
    } else {
      this.moved = object;
      const box = new THREE.Box3().setFromArray(surface.mesh.positions);
      box.getCenter(this.middle);
      this.followObject();
      this.gizmo.attach(this.pivot);
      this.o.say(`${surface.info.name} can be moved`);
    }
    this.o.onChange();
  }

  setGizmo(mode: 'translate' | 'rotate'): void {
    this.gizmo.setMode(mode);
    this.o.stage.ask();
  }

  getPose(): { position: THREE.Vector3; rotation: THREE.Quaternion } | null {
    const surface = this.moved === null ? undefined : this.o.stage.surfaces[this.moved];
    return surface ? findPose(surface, this.middle) : null;
  }

  private followObject(): void {
    const pose = this.moved === null || this.gizmo.dragging ? null : this.getPose();
    if (!pose) return;
    this.pivot.quaternion.copy(pose.rotation);
    this.pivot.position.copy(pose.position);
  }

  private sendPivot(): void {
    const isUnderWay = this.wanted !== null;
    this.wanted = { position: this.pivot.position.clone(), rotation: this.pivot.quaternion.clone() };
    if (isUnderWay) return;
    // The newest place goes out. The pivot itself follows the object again as soon as it is let go.
    window.setTimeout(() => {
      const { wanted } = this;
      this.wanted = null;
      if (wanted && this.moved !== null) this.move(wanted.position, wanted.rotation);
    }, PAUSE);
  }

  // The middle goes to `position`, the mesh turns about it.
  move(position: THREE.Vector3, rotation: THREE.Quaternion): void {
    const { x, y, z, w } = rotation;
    this.o
      .connection()
      .ask({ type: 'move', object: this.moved, position: toVector(position), rotation: [w, x, y, z] })
      .catch((problem) => this.o.fail(problem));
  }
}
