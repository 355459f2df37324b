// The page of `tulle view`: builds itself from what the server says, and ties the parts together.
import * as THREE from 'three';
import { type Answer, Connection } from './connection.ts';
import { chooseColor } from './color.ts';
import { button, get, make, makeIcon } from './dom.ts';
import { EditorPanel } from './editor_panel.ts';
import { canFilm } from './film.ts';
import { Fetcher, FrameStore, type KeptFrame } from './frames.ts';
import { Hold } from './hold.ts';
import { handleKeys, type Key, showKeys } from './keys.ts';
import { makeKeyTable } from './key_table.ts';
import { readLink, writeLink, type ViewLink } from './link.ts';
import { LiveBar } from './live.ts';
import { showNumbers } from './numbers.ts';
import { Overlays } from './overlays.ts';
import {
  type FullLook,
  makeHoldPanel,
  makeLookPanel,
  makeObjectPanel,
  makeOverlayPanel,
  makeSettingsPanel,
  makeTakePanel,
  SelectionPanel,
} from './panels.ts';
import { Picker, type Selection } from './pick.ts';
import { Plots } from './plots.ts';
import {
  type ChangedMessage,
  type DocumentMessage,
  FrameDecoder,
  KIND,
  type Mesh,
  type OverlayMessage,
  type PickedMessage,
  readHeader,
  readMesh,
  readOverlay,
  type SeriesMessage,
  type StateMessage,
  VERSION,
} from './protocol.ts';
import { canDraw, Corner, Stage } from './stage.ts';
import { Surface } from './surface.ts';
import { Take } from './take.ts';
import { Timeline } from './timeline.ts';
import './style.css';

const FRAME_BYTES = 192e6; // of frames that are kept
const ACKNOWLEDGE = 10; // milliseconds between acknowledgements, which name the newest frame; the server takes 200 messages a second
const LINK_PAUSE = 300; // milliseconds before the address follows the view
const START_DIRECTION = new THREE.Vector3(0.55, -1, 0.62);

class Page {
  private document: DocumentMessage | null = null;
  private meshes: Mesh[] = [];
  private decoder: FrameDecoder | null = null;
  private received = 0;
  private acknowledgedAt = 0; // by performance.now()
  private newest = 0;
  private acknowledgement = 0;
  private liveOverlays = new Map<string, OverlayMessage>();
  private hasLiveFrame = false;
  private hasLiveOverlay = false;
  private shownTime = 0;
  private link: ViewLink = readLink(location.hash);
  private linkTimer = 0;
  private hasView = false; // the camera was set once
  private readonly connection: Connection;
  private readonly editor: EditorPanel;
  private readonly view = get('view');
  private readonly stage: Stage | null;
  private readonly overlays: Overlays | null;
  private readonly picker: Picker | null;
  private readonly hold: Hold | null;
  private readonly selectionPanel: SelectionPanel | null;
  private readonly store = new FrameStore(FRAME_BYTES);
  private readonly fetcher: Fetcher;
  private readonly timeline: Timeline;
  private readonly liveBar: LiveBar;
  private readonly plots: Plots;
  private readonly corner: Corner;
  private readonly take: Take | null;
  private readonly keys: Key[];
  private readonly look: FullLook = {
    shading: 'smooth',
    texture: 'plain',
    hasWires: false,
    hasShadows: true,
    hasGround: true,
    ...this.link.look,
  };
  private settingTimer = 0;
  private readonly settings = new Map<string, { what: string; value: unknown; object?: number }>();
  private updateHoldPanel: () => void = () => {};
  private asked = 0; // number of the newest pick
  private told: Selection | null = null; // that was read out

  constructor() {
    this.stage = canDraw() ? new Stage(this.view) : null;
    this.overlays = this.stage && new Overlays(this.stage);
    this.picker = this.stage && new Picker(this.stage);
    this.fetcher = new Fetcher(
      this.store,
      1,
      (request) => this.connection.send(request),
      (kept) => this.hasOverlays(kept),
    );
    this.timeline = new Timeline(
      this.store,
      this.fetcher,
      (kept) => this.showKept(kept),
      (words) => this.say(words),
    );
    this.liveBar = new LiveBar(
      (message) => this.command(message),
      (words) => this.say(words),
    );
    this.plots = new Plots((group, buckets) =>
      this.connection.ask<SeriesMessage>({ type: 'series', names: group.names, buckets }),
    );
    this.corner = new Corner(() => ({
      drawn: this.stage?.drawn ?? 0,
      received: this.received,
      isSoftware: this.stage?.isSoftware ?? false,
    }));
    this.hold =
      this.stage &&
      this.picker &&
      new Hold({
        stage: this.stage,
        picker: this.picker,
        connection: () => this.connection,
        say: (words) => this.say(words),
        fail: (problem) => this.fail(problem),
        onChange: () => this.onHold(),
      });
    this.selectionPanel =
      this.stage &&
      new SelectionPanel(this.stage, {
        chooseVertex: (object, vertex) => this.chooseVertex(object, vertex),
        frame: () => this.frameSelection(),
        choosePart: (part) => this.picker!.selection && this.picker!.select({ ...this.picker!.selection, part }),
        grab: () => this.hold!.grabSelection(),
        letGo: () => this.hold!.letGo(),
        nudge: (...by) => this.hold!.nudge(...by),
        cut: () => this.hold!.cut(),
        clear: () => this.picker!.select(null),
      });
    this.take =
      this.stage &&
      new Take({
        stage: this.stage,
        timeline: this.timeline,
        getName: () => this.document?.path ?? 'tulle',
        fail: (problem) => this.fail(problem),
      });
    this.editor = new EditorPanel(get('editor'), {
      connection: () => this.connection,
      fail: (problem) => this.fail(problem),
      close: () => this.toggleEditor(false),
    });
    this.keys = this.makeKeys();
    this.connect();
    const url = new URL('session', location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    url.hash = '';
    this.connection = new Connection(url.href, {
      onText: (message) => this.takeText(message),
      onBinary: (buffer) => this.takeBinary(buffer),
      onStatus: (status, reason) => this.showStatus(status, reason),
    });
    this.makeTools();
  }

  // Ties parts together that are there from the start.
  private connect(): void {
    const { stage, overlays, picker } = this;
    handleKeys(this.keys, this.view);
    get('foot').append(this.timeline.element, this.liveBar.element, this.plots.element);
    this.timeline.element.hidden = this.liveBar.element.hidden = this.plots.element.hidden = true;
    this.timeline.onWant = () => this.follow();
    this.plots.onPick = (step) => this.goToStep(step);
    get('stage').append(this.corner.element);
    if (!stage || !overlays || !picker) {
      this.showNumbers();
      return;
    }
    get('stage').append(overlays.legends, this.makeAxes());
    overlays.onChange = () => {
      this.connection?.send({ type: 'overlays', names: overlays.sources });
      this.liveOverlays.clear();
      if (this.document && !this.document.live) {
        this.timeline.forget();
        this.timeline.refresh();
      }
      this.writeLinkSoon();
    };
    picker.onSelect = () => this.pick();
    stage.beforeDraw = () => this.beforeDraw();
    stage.afterDraw = () => this.afterDraw();
    if (this.link.overlays) overlays.setActive(this.link.overlays);
    stage.setLook(this.look, this.look.hasGround);
  }

  // ---- words ----

  private say(words: string): void {
    get('status').textContent = words;
  }

  // A problem, until it is dismissed or has been there for a while.
  private fail(problem: unknown): void {
    const words = problem instanceof Error ? problem.message : String(problem);
    const note = make(
      'p',
      {},
      make('span', {}, words),
      button('Dismiss', () => note.remove()),
    );
    get('notes').replaceChildren(note);
    setTimeout(() => note.remove(), 12000);
  }

  private showStatus(status: 'connecting' | 'open' | 'lost', reason: string): void {
    const badge = get('link-state');
    const words = {
      connecting: 'Connecting',
      open: 'Connected',
      lost: reason ? `Lost: ${reason}` : 'Connection lost, trying again',
    };
    if (status === 'connecting' && badge.classList.contains('lost')) return;
    if (badge.textContent !== words[status]) badge.textContent = words[status];
    badge.classList.toggle('lost', status === 'lost');
    if (status === 'lost') {
      this.say('the connection is lost; the page tries again');
      this.hold?.forget();
    }
    if (status === 'open') {
      this.say('connected');
      this.newest = 0;
      if (this.overlays?.active.size) this.connection.send({ type: 'overlays', names: this.overlays.sources });
    }
  }

  private command(message: { type: string; [name: string]: unknown }): void {
    this.connection.ask(message).catch((problem) => this.fail(problem));
  }

  // ---- what the server says ----

  private takeText(message: Answer): void {
    if (message.type === 'document') this.openDocument(message as unknown as DocumentMessage);
    else if (message.type === 'changed') this.change(message as unknown as ChangedMessage);
    else if (message.type === 'state') this.showState(message as unknown as StateMessage);
    else if (message.type === 'error') this.fail(message.message);
  }

  private takeBinary(buffer: ArrayBuffer): void {
    try {
      const header = readHeader(buffer);
      if (header.kind === KIND.mesh) this.takeMesh(readMesh(buffer));
      else if (header.kind === KIND.frame) this.takeFrame(buffer);
      else if (header.kind === KIND.overlay) this.takeOverlay(readOverlay(buffer));
    } catch (problem) {
      this.connection.restart((problem as Error).message);
    }
  }

  private takeMesh(mesh: Mesh): void {
    this.meshes[mesh.object] = mesh;
    const { document } = this;
    if (document && document.objects.every((_, k) => this.meshes[k])) this.openMeshes(document);
  }

  private takeFrame(buffer: ArrayBuffer): void {
    if (!this.decoder) throw new Error('a frame came before its meshes');
    const header = this.decoder.read(buffer);
    this.received++;
    this.newest = header.sequence;
    const wait = Math.max(0, this.acknowledgedAt + ACKNOWLEDGE - performance.now());
    this.acknowledgement ||= window.setTimeout(() => this.acknowledge(), wait);
    if (this.document?.live) {
      this.shownTime = header.time;
      this.hasLiveFrame = true;
      this.view.dataset.frame = String(header.frame);
      this.stage?.ask();
      return;
    }
    // A frame of an older request comes without the overlays that were asked for since.
    const asked = this.fetcher.expects(header.frame) ? (this.overlays?.sources ?? []) : [];
    this.store.keep(header, this.decoder, this.timeline.frame, asked);
    this.fetcher.take(header.frame);
    this.timeline.take(header.frame);
  }

  private acknowledge(): void {
    this.acknowledgement = 0;
    this.acknowledgedAt = performance.now();
    this.connection.send({ type: 'got', sequence: this.newest });
  }

  private takeOverlay(message: OverlayMessage): void {
    if (this.document?.live) {
      this.liveOverlays.set(message.name, message);
      this.hasLiveOverlay = true;
      this.stage?.ask();
      return;
    }
    this.store.addOverlay(message, this.timeline.frame);
    const kept = this.store.get(this.timeline.frame);
    if (kept && message.frame === kept.frame) this.overlays?.show(kept.overlays);
    this.timeline.refresh();
  }

  // The overlays of a frame that come with it are there; those that take long may come later.
  private hasOverlays(kept: KeptFrame): boolean {
    const { overlays, document } = this;
    return (
      !overlays ||
      overlays.sources.every((name) => kept.overlays.has(name) || kept.asked.has(name) || !document?.overlays.includes(name))
    );
  }

  // ---- a document ----

  private openDocument(message: DocumentMessage): void {
    if (message.version !== VERSION)
      this.fail(`the program speaks version ${message.version}, this page ${VERSION}: load it again`);
    this.document = message;
    this.meshes = [];
    this.decoder = null;
    this.store.clear();
    document.title = `${message.title || message.path} \u2013 Tulle`;
    get('title').textContent = message.title || message.path;
    get('title').title = message.path;
    const kind = get('kind');
    kind.hidden = false;
    kind.textContent = message.live ? 'live scene' : message.kind;
    this.timeline.element.hidden = message.live || message.frame_count < 2;
    this.liveBar.element.hidden = !message.live;
    this.liveBar.show(null);
    this.timeline.forget();
    this.timeline.setRun(message.frame_count, message.frame_seconds, message.is_under_way);
    this.plots.setSeries(message.series ?? []);
    this.toolbar('plots').hidden = !message.series?.length;
    if (!message.series?.length) this.plots.element.hidden = true;
    this.toolbar('editor').hidden = !message.abilities.includes('edit');
    this.describeView();
    this.showNumbers();
    const isEditable = message.abilities.includes('edit');
    if (isEditable && message.problems?.length) this.toggleEditor(true);
    else if (isEditable && !get('editor').hidden) void this.editor.load(message);
    if (message.objects.length === 0) this.openMeshes(message);
  }

  private openMeshes(document: DocumentMessage): void {
    this.decoder = new FrameDecoder(this.meshes);
    const { stage } = this;
    if (!stage || !this.overlays || !this.hold) return;
    const counts: Record<string, number> = {};
    const surfaces = this.meshes.map((mesh, object) => {
      const info = document.objects[object],
        kind = info.role === 'obstacle' ? 'obstacle' : 'cloth';
      counts[kind] = (counts[kind] ?? -1) + 1;
      const color = info.color
        ? new THREE.Color().setRGB(...info.color, THREE.SRGBColorSpace).toArray()
        : chooseColor(kind, counts[kind]);
      return new Surface(mesh, info, color as [number, number, number]);
    });
    surfaces.forEach((surface, object) => surface.setObject(this.decoder!.objects[object]));
    const { low, high } = document.box,
      box = new THREE.Box3(new THREE.Vector3(...low), new THREE.Vector3(...high));
    this.hold.forget();
    this.overlays.clear();
    stage.setSurfaces(
      surfaces,
      new THREE.Vector3(...document.up).normalize(),
      box.isEmpty() ? new THREE.Box3().setFromCenterAndSize(new THREE.Vector3(), new THREE.Vector3(1, 1, 1)) : box,
    );
    this.hold.isAble = document.live && document.abilities.includes('grab');
    this.makePanels(document);
    if (!this.hasView) this.setFirstView(document);
    this.hasView = true;
    const { selection } = this.picker!;
    this.picker!.select(this.link.selection ?? selection);
    if (!document.live) this.timeline.setFrame(this.link.frame ?? this.timeline.frame);
    this.link = {};
  }

  private setFirstView(document: DocumentMessage): void {
    const { camera } = this.stage!,
      box = this.stage!.findBox(),
      scene = document.camera;
    camera.frame(box, START_DIRECTION, true);
    if (this.link.camera) return camera.setNumbers(this.link.camera);
    if (!scene) return undefined;
    const target = scene.target ? new THREE.Vector3(...scene.target) : camera.controls.target.clone();
    if (scene.position) return camera.takePlace(new THREE.Vector3(...scene.position), target, scene.field_of_view);
    if (!scene.orbit) return undefined;
    const [azimuth, elevation] = scene.orbit;
    const direction = new THREE.Vector3(
      Math.cos(elevation) * Math.cos(azimuth),
      Math.cos(elevation) * Math.sin(azimuth),
      Math.sin(elevation),
    );
    if (!scene.distance) return camera.frame(box, direction, true);
    return camera.takePlace(target.clone().addScaledVector(direction, scene.distance), target, scene.field_of_view);
  }

  private change(message: ChangedMessage): void {
    if (!this.document) return;
    Object.assign(this.document, { frame_count: message.frame_count, is_under_way: message.is_under_way });
    this.timeline.element.hidden = this.document.live || message.frame_count < 2;
    this.timeline.setRun(message.frame_count, this.document.frame_seconds, message.is_under_way);
    this.plots.load();
  }

  private describeView(): void {
    const { document } = this;
    if (!document) return;
    const objects = document.objects
      .slice(0, 12)
      .map(({ name, role, triangle_count: count }) => `${name} (${role}, ${count} triangles)`);
    const more = document.objects.length > 12 ? ` and ${document.objects.length - 12} more` : '';
    this.view.setAttribute(
      'aria-label',
      `${document.live ? 'Live scene' : `${document.kind[0].toUpperCase()}${document.kind.slice(1)}`} ${document.title || document.path}: ${objects.join(', ')}${more}`,
    );
  }

  // ---- frames ----

  private showKept(kept: KeptFrame): void {
    this.stage?.surfaces.forEach((surface, k) => surface.setState(kept.positions[k], kept.isAbsent[k] === 1));
    this.shownTime = kept.time;
    this.view.dataset.frame = String(kept.frame);
    this.overlays?.show(kept.overlays);
    this.picker?.update();
    this.stage?.ask();
    this.showNumbers();
  }

  private beforeDraw(): void {
    const { decoder, stage } = this;
    if (this.hasLiveFrame && decoder && stage) {
      this.hasLiveFrame = false;
      stage.surfaces.forEach((surface, k) => surface.setObject(decoder.objects[k]));
      this.picker!.update();
    }
    if (this.hasLiveOverlay) {
      this.hasLiveOverlay = false;
      this.overlays!.show(this.liveOverlays);
    }
    this.hold?.update();
  }

  private afterDraw(): void {
    this.view.dataset.drawn = this.view.dataset.frame ?? '';
    this.writeLinkSoon();
  }

  private showState(state: StateMessage): void {
    const before = this.liveBar.state;
    this.liveBar.show(state);
    this.hold?.checkHeld(state.held);
    if (state.message && state.message !== before?.message) this.say(state.message);
    this.plots.setStep(state.step);
    if (!before || before.step !== state.step) this.plots.load();
    this.showNumbers();
  }

  private get stepsPerFrame(): number {
    const { document } = this;
    return document && document.step_seconds > 0 && document.frame_seconds > 0
      ? document.frame_seconds / document.step_seconds
      : 1;
  }

  private goToStep(step: number): void {
    if (this.document?.live) return;
    this.timeline.pause();
    this.timeline.setFrame(Math.round(step / this.stepsPerFrame));
  }

  // What goes along with the timeline.
  private follow(): void {
    this.plots.setStep(this.timeline.frame * this.stepsPerFrame);
    this.pickSoon();
    this.writeLinkSoon();
  }

  // ---- picking ----

  private chooseVertex(object: number, vertex: number): boolean {
    const isThere = this.picker!.chooseVertex(object, vertex);
    if (!isThere) this.fail(`there is no vertex ${vertex} in this object`);
    return isThere;
  }

  private pickTimer = 0;

  private pickSoon(): void {
    if (!this.picker?.selection) return;
    clearTimeout(this.pickTimer);
    this.pickTimer = window.setTimeout(() => this.pick(), 150);
  }

  private pick(): void {
    const selection = this.picker?.selection ?? null,
      hold = { isAble: this.hold?.isAble ?? false, isHolding: this.hold?.isHolding ?? false };
    const turn = ++this.asked;
    this.writeLinkSoon();
    this.selectionPanel?.show(selection, null, hold);
    if (!selection) return;
    const { object, triangle, weights } = selection;
    if (selection !== this.told) {
      this.told = selection;
      this.say(`${selection.part} of ${this.document?.objects[object]?.name} chosen`);
      if (this.hold?.tool === 'move' && this.hold.moved !== object) this.hold.attachTo(object);
    }
    const frame = this.document?.live ? {} : { frame: this.timeline.frame };
    this.connection
      .ask<PickedMessage>({ type: 'pick', ...frame, object, triangle, weights })
      .then(
        (picked) =>
          turn === this.asked &&
          this.selectionPanel?.show(selection, picked, { isAble: hold.isAble, isHolding: this.hold?.isHolding ?? false }),
      )
      .catch((problem) => turn === this.asked && this.fail(problem));
    // A live scene moves on: ask again while something is chosen.
    clearTimeout(this.pickTimer);
    if (this.document?.live && this.liveBar.isRunning) this.pickTimer = window.setTimeout(() => this.repick(), 500);
  }

  private repick(): void {
    // A button that has the focus is not to be replaced under the finger.
    if (this.selectionPanel?.element.contains(window.document.activeElement))
      this.pickTimer = window.setTimeout(() => this.repick(), 500);
    else this.pick();
  }

  private frameSelection(): void {
    const { stage, picker } = this;
    if (!stage || !picker?.selection) return this.frameAll();
    const { object, triangle, weights } = picker.selection,
      surface = stage.surfaces[object],
      box = new THREE.Box3();
    box.expandByPoint(surface.getPoint(triangle, weights));
    return stage.camera.frame(box.expandByScalar(stage.findBox().getSize(new THREE.Vector3()).length() * 0.06));
  }

  private frameAll(): void {
    this.stage?.camera.frame(this.stage.findBox());
  }

  private onHold(): void {
    this.updateHoldPanel();
    this.view.toggleAttribute('data-held', this.hold?.isHolding ?? false);
    const hint = get('hint'),
      { hold } = this;
    hint.hidden = !hold?.isByKeys;
    if (hold?.isByKeys) hint.textContent = 'Arrow keys, Page Up and Page Down move the held point; Enter lets go';
    if (this.picker?.selection) this.pick();
  }

  // ---- parts of the page ----

  private makePanels(document: DocumentMessage): void {
    const { stage, overlays, hold, take } = this;
    if (!stage || !overlays || !hold || !take || !this.selectionPanel) return;
    const close = make(
      'div',
      { class: 'sheet-close' },
      button('Close panels', () => this.togglePanels(false)),
    );
    const holdPanel = hold.isAble ? makeHoldPanel(hold) : null;
    this.updateHoldPanel = holdPanel?.update ?? (() => {});
    this.selectionPanel.setDocument(document);
    get('panels').replaceChildren(
      close,
      ...(holdPanel ? [holdPanel.element] : []),
      makeLookPanel(this.look, (look) => {
        stage.setLook(look, look.hasGround);
        this.writeLinkSoon();
      }),
      makeOverlayPanel(overlays, document.overlays),
      this.selectionPanel.element,
      ...(hold.isAble ? [makeSettingsPanel(document, (what, value, object) => this.set(what, value, object))] : []),
      makeObjectPanel(stage, (object) => stage.camera.frame(stage.findBox([stage.surfaces[object]]))),
      makeTakePanel(
        {
          picture: () => take.picture(),
          film: (from, to, rate) => void take.film(from, to, rate),
          stopFilm: () => take.stopFilm(),
          link: () => void this.copyLink(),
          recording: () => take.recording(),
          session: () =>
            this.connection
              .ask({ type: 'save_session' })
              .then((answer) => this.say(`saved as ${String(answer.file)}`))
              .catch((problem) => this.fail(problem)),
        },
        document,
        canFilm(),
      ),
    );
  }

  // Of many changes of a slider the newest goes out.
  private set(what: string, value: unknown, object?: number): void {
    this.settings.set(`${what} ${object ?? ''}`, { what, value, object });
    this.settingTimer ||= window.setTimeout(() => {
      this.settingTimer = 0;
      for (const setting of this.settings.values()) this.command({ type: 'set', ...setting });
      this.settings.clear();
    }, 60);
  }

  private readonly toolButtons = new Map<string, HTMLButtonElement>();

  private toolbar(name: string): HTMLButtonElement {
    return this.toolButtons.get(name)!;
  }

  private makeTools(): void {
    const add = (name: string, label: string, act: () => void, attributes: Record<string, string | boolean> = {}) => {
      const made = button(label, act, attributes);
      this.toolButtons.set(name, made);
      get('tools').append(made);
      return made;
    };
    add('editor', 'Edit', () => this.toggleEditor(), { 'aria-pressed': 'false', 'aria-controls': 'editor', hidden: true });
    add('plots', 'Plots', () => this.togglePlots(), { 'aria-pressed': 'false', hidden: true });
    add('panels', 'Panels', () => this.togglePanels(), { 'aria-pressed': 'true', 'aria-controls': 'panels' });
    add('keys', '?', () => this.showKeys(), { 'aria-label': 'Keys' });
    if (matchMedia('(max-width: 700px)').matches) this.togglePanels(false);
  }

  private makeAxes(): HTMLElement {
    const axes = [
      ['x', 'X'],
      ['y', 'Y'],
      ['z', 'Z'],
    ] as const;
    const frame = button('', () => this.frameAll(), { 'aria-label': 'Frame all', title: 'Frame all (Home)' });
    frame.append(
      makeIcon(
        'M2 6V2h4v1.500H3.500V6zM10 2h4v4h-1.500V3.500H10zM2 10h1.500v2.500H6V14H2zM12.500 10H14v4h-4v-1.500h2.500zM6 6h4v4H6z',
      ),
    );
    return make(
      'div',
      { class: 'axes', role: 'group', 'aria-label': 'Views' },
      frame,
      ...axes.map(([axis, label]) =>
        button(label, () => this.stage!.camera.lookAlong(this.flip(axis)), {
          'aria-label': `View along ${label}`,
          title: `View along ${label}; again: from the other side`,
        }),
      ),
    );
  }

  // From the other side where it is seen along this axis already.
  private flip(axis: string): string {
    const direction = this.stage!.camera.getAxes()[2].getComponent('xyz'.indexOf(axis));
    const isFirst = axis === 'y' ? -1 : 1; // the front is seen along y
    return direction * isFirst > 0.99 ? (isFirst > 0 ? `-${axis}` : axis) : isFirst > 0 ? axis : `-${axis}`;
  }

  private togglePanels(isOn = get('panels').hidden): void {
    get('panels').hidden = !isOn;
    if (isOn && !get('editor').hidden && matchMedia('(max-width: 1100px)').matches) this.toggleEditor(false);
    this.toolbar('panels')?.setAttribute('aria-pressed', String(isOn));
  }

  private togglePlots(): void {
    const { element } = this.plots;
    element.hidden = !element.hidden;
    this.toolbar('plots').setAttribute('aria-pressed', String(!element.hidden));
    if (!element.hidden) this.plots.load();
  }

  private showKeys(): void {
    const program = this.document ? `Tulle ${this.document.program}. ` : '';
    showKeys(
      this.keys,
      `${program}The page holds three.js, CodeMirror and Lezer, all under the MIT licence; their licences stand at the top of app.js.`,
    );
  }

  private showNumbers(): void {
    if (this.stage) return;
    const state = this.liveBar.state;
    if (!this.view.hidden) this.togglePanels(false);
    this.view.hidden = true;
    showNumbers(get('stage'), { document: this.document, state, frame: this.timeline.frame, time: this.shownTime });
  }

  private toggleEditor(isOn = get('editor').hidden): void {
    get('editor').hidden = !isOn;
    this.toolbar('editor').setAttribute('aria-pressed', String(isOn));
    // On a small screen there is room for one of them beside the picture.
    if (isOn && matchMedia('(max-width: 1100px)').matches) this.togglePanels(false);
    if (isOn && this.document) void this.editor.load(this.document).then(() => this.editor.focus());
  }

  // ---- links ----

  private makeLink(): ViewLink {
    return {
      frame: this.document?.live ? undefined : this.timeline.frame,
      camera: this.stage?.camera.toNumbers(),
      overlays: this.overlays ? [...this.overlays.active] : [],
      look: this.look,
      selection: this.picker?.selection ?? undefined,
    };
  }

  private writeLinkSoon(): void {
    if (!this.hasView) return;
    clearTimeout(this.linkTimer);
    this.linkTimer = window.setTimeout(() => history.replaceState(null, '', `#${writeLink(this.makeLink())}`), LINK_PAUSE);
  }

  private async copyLink(): Promise<void> {
    const address = `${location.origin}${location.pathname}#${writeLink(this.makeLink())}`;
    history.replaceState(null, '', address);
    try {
      await navigator.clipboard.writeText(address);
      this.say('the link is copied');
    } catch {
      this.fail('the browser did not allow to copy; the address of this page is the link');
    }
  }

  // ---- keys ----

  private makeKeys(): Key[] {
    return makeKeyTable({
      stage: this.stage,
      hold: this.hold,
      picker: this.picker,
      timeline: this.timeline,
      liveBar: this.liveBar,
      corner: this.corner,
      isLive: () => this.document?.live ?? false,
      isShown: (tool) => !this.toolbar(tool).hidden,
      frameAll: () => this.frameAll(),
      frameSelection: () => this.frameSelection(),
      lookAlong: (axis) => this.stage!.camera.lookAlong(this.flip(axis)),
      flipLook: (label) => this.flipLook(label),
      togglePlots: () => this.togglePlots(),
      togglePanels: () => this.togglePanels(),
      toggleEditor: () => this.toggleEditor(),
      showKeys: () => this.showKeys(),
    });
  }

  private flipLook(label: string): void {
    const box = [...get('panels').querySelectorAll('label')].find((each) => each.textContent === label);
    box?.querySelector('input')?.click();
  }
}

new Page();
