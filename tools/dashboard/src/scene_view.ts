// The scene: robot, cloud, map, ground, target, surfaces, candidates, partner, people, path. z is up, metres, the robot's base frame.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { type PointCloud, type SceneUpdate, type Transform, bytesOf } from "./messages";
import { ObjectMotion } from "./object_motion";
import type { Painter } from "./pace";
import { PalmPath } from "./palm_path";
import { RobotView } from "./robot_view";
import { cellsOf, dispose, label, objectOf, place } from "./scene_entities";

const LAYERS = ["robot", "cloud", "map", "unseen", "ground", "target", "surfaces", "candidates", "partner", "people",
  "gripper", "path", "at rest"] as const;
type Layer = (typeof LAYERS)[number];
/** Not there at first: they cover what is more asked for. */
const HIDDEN: Layer[] = ["unseen", "surfaces"];
/** Layers that go where the object goes. */
const CARRIED: Layer[] = ["target", "surfaces", "candidates", "partner", "gripper"];
/** A frame that moves by less moves nothing by a pixel (m, rad). */
const SEEN_M = 2e-4, SEEN_RAD = 2e-4;
/** Words above the object stand higher than the partner's (m). */
const CAPTION_M = 0.12;
/** Less is no rise that anybody sees (m). */
const RISEN_M = 0.002;
/** Layers that /scene fills. */
const OF_SCENE: Layer[] = ["ground", "target", "surfaces", "candidates", "partner", "gripper", "path"];

function layerOf(id: string): Layer {
  if (id === "ground") return "ground";
  if (id.startsWith("surface")) return "surfaces";
  if (id.startsWith("candidate")) return "candidates";
  if (id === "partner" || id === "gripper") return id;
  if (id === "path" || id === "optimum") return "path";
  return "target";
}

export class SceneView implements Painter {
  onPick: (id: number) => void = () => {};
  onTouch: () => void = () => {};
  readonly robot = new RobotView();
  readonly motion = new ObjectMotion();
  readonly palm = new PalmPath();
  /** Where the object rested, as a cube of edge one; null: none was found. */
  restBox: THREE.Matrix4 | null = null;

  private partner: Transform | null = null;
  private rest = new THREE.LineSegments(new THREE.EdgesGeometry(new THREE.BoxGeometry(1, 1, 1)),
    new THREE.LineDashedMaterial({ color: "#777777", dashSize: 0.05, gapSize: 0.04 }));
  private caption: THREE.Sprite | null = null;
  private captionWords = "";
  private drawn_s = 0;
  private stale = true;
  private touches = 0;
  private renderer: THREE.WebGLRenderer;
  private scene = new THREE.Scene();
  private camera = new THREE.PerspectiveCamera(45, 1, 0.05, 30);
  private controls: OrbitControls;
  private layers = new Map<Layer, THREE.Group>();
  private frames = new Map<string, THREE.Group>();
  private points: THREE.Points | null = null;
  private focus = new THREE.Vector3(0.7, 0, 0.3);
  private marker = new THREE.Mesh(new THREE.TorusGeometry(0.04, 0.006, 8, 32),
    new THREE.MeshBasicMaterial({ color: "#d55e00", depthTest: false }));

  constructor(private canvas: HTMLCanvasElement, toggles: HTMLElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, preserveDrawingBuffer: true });
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    THREE.Object3D.DEFAULT_UP.set(0, 0, 1);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enableDamping = false;
    this.side("1");
    const sun = new THREE.DirectionalLight(0xffffff, 1.6);
    sun.position.set(1, -2, 4);
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x777788, 1.6), sun);
    const grid = new THREE.GridHelper(4, 16, 0x888888, 0x888888);
    grid.rotateX(Math.PI / 2);
    (grid.material as THREE.Material).transparent = true;
    (grid.material as THREE.Material).opacity = 0.3;
    this.scene.add(grid);
    for (const name of LAYERS) {
      const group = new THREE.Group();
      this.layers.set(name, group);
      this.scene.add(group);
      const label = document.createElement("label");
      const box = document.createElement("input");
      box.type = "checkbox";
      box.checked = !HIDDEN.includes(name);
      group.visible = box.checked;
      box.onchange = () => { group.visible = box.checked; };
      label.append(box, name);
      toggles.append(label);
    }
    this.layers.get("robot")!.add(this.robot.group);
    this.layers.get("path")!.add(this.robot.ghost, this.palm.group);
    this.robot.onPalm = (at) => this.palm.palm(at);
    for (const name of CARRIED) this.layers.get(name)!.matrixAutoUpdate = false;
    this.rest.computeLineDistances();
    this.rest.visible = false;
    this.layers.get("at rest")!.add(this.rest);
    this.marker.visible = false;
    this.marker.renderOrder = 10;
    this.scene.add(this.marker);
    canvas.addEventListener("click", (event) => this.pick(event));
    canvas.addEventListener("keydown", (event) => {
      if ("1234".includes(event.key)) this.side(event.key);
      if (event.key === "f") this.controls.target.copy(this.focus);
      const turn = { ArrowLeft: -0.1, ArrowRight: 0.1 }[event.key], tilt = { ArrowUp: -0.1, ArrowDown: 0.1 }[event.key];
      if (turn !== undefined || tilt !== undefined) this.orbit(turn ?? 0, tilt ?? 0);
      else if (event.key === "+" || event.key === "-") this.zoom(event.key === "+" ? 0.9 : 1.1);
      else if (!"1234f".includes(event.key)) return;
      this.touch();
      event.preventDefault();
    });
    this.controls.addEventListener("change", () => this.touch());
    toggles.addEventListener("change", () => this.touch());
    new ResizeObserver(() => this.touch()).observe(canvas);
  }

  get gl(): WebGL2RenderingContext { return this.renderer.getContext() as WebGL2RenderingContext; }

  /** Something that is seen has changed. */
  touch(): void {
    this.stale = true;
    this.canvas.dataset.touches = String(++this.touches);
    this.onTouch();
  }

  wants(): boolean { return this.stale || !this.motion.settled || this.robot.ghost.visible; }

  draw(now_ms: number): void {
    this.stale = false;
    const touches = this.touches;
    this.fit();
    this.robot.tick(now_ms / 1000);
    this.carry(now_ms / 1000);
    this.controls.update();
    if (this.marker.visible) this.marker.lookAt(this.camera.position);
    this.renderer.render(this.scene, this.camera);
    this.canvas.dataset.drawn = String(touches);
  }

  background(colour: string): void {
    this.scene.background = new THREE.Color(colour);
    this.touch();
  }

  reset(): void {
    for (const name of LAYERS)
      if (name !== "robot") this.clear(name);
    this.robot.show(null);
    this.marker.visible = false;
    this.partner = null;
    this.restBox = null;
    this.motion.reset();
    this.palm.reset();
    this.say("");
    this.touch();
  }

  /** Words above the object; none: "". */
  say(words: string): void {
    if (words === this.captionWords) return;
    this.touch();
    this.captionWords = words;
    if (this.caption) {
      dispose(this.caption);
      this.caption.removeFromParent();
      this.caption = null;
    }
    if (words === "" || !this.restBox) return;
    const at = new THREE.Vector3().setFromMatrixPosition(this.restBox);
    const top = [0, 1, 2].reduce((sum, i) => sum + Math.abs(this.restBox!.elements[4 * i + 2]!), 0) / 2;
    this.caption = label(words, { position: { x: at.x, y: at.y, z: at.z + top }, orientation: { x: 0, y: 0, z: 0, w: 1 } },
      { r: 0.9, g: 0.62, b: 0, a: 1 });
    this.caption.position.z += CAPTION_M;
    this.layers.get("target")!.add(this.caption);
  }

  /** Object and partner where they are at this moment. */
  private carry(now_s: number): void {
    this.motion.tick(Math.min(1, Math.max(0, now_s - this.drawn_s)));
    this.drawn_s = now_s;
    for (const name of CARRIED) {
      const group = this.layers.get(name)!;
      group.matrix.copy(this.motion.matrix);
      group.matrixWorldNeedsUpdate = true;
    }
    for (const cells of this.layers.get("map")!.children)
      if (cells.name === "target") {
        cells.matrixAutoUpdate = false;
        cells.matrix.copy(this.motion.matrix);
        cells.matrixWorldNeedsUpdate = true;
      }
    const sphere = this.layers.get("partner")!.children[0]?.children[0];
    if (this.partner && sphere) {
      const t = this.partner.translation;
      this.layers.get("partner")!.matrix.makeTranslation(t.x - sphere.position.x, t.y - sphere.position.y, t.z - sphere.position.z);
    }
    const raised = new THREE.Vector3().setFromMatrixPosition(this.motion.matrix).length();
    this.rest.visible = this.restBox !== null && raised > RISEN_M;
    this.canvas.dataset.raisedMm = (1000 * this.motion.matrix.elements[14]!).toFixed(1);
  }

  transforms(list: Transform[], at_s: number): void {
    for (const t of list) {
      if (t.child_frame_id === "object") this.motion.pose(t, at_s);
      if (t.child_frame_id === "partner") this.partner = t;
      const frame = this.frame(t.child_frame_id), at = frame.position.clone(), turn = frame.quaternion.clone();
      place(frame, { position: t.translation, orientation: t.rotation });
      if (at.distanceTo(frame.position) > SEEN_M || turn.angleTo(frame.quaternion) > SEEN_RAD) this.touch();
    }
  }

  cloud(message: PointCloud): void {
    this.touch();
    const bytes = bytesOf(message.data);
    const view = new DataView(bytes.buffer);
    const count = Math.floor(bytes.length / message.point_stride);
    const offset = (name: string) => message.fields.find((f) => f.name === name)?.offset ?? 0;
    const x = offset("x"), y = offset("y"), z = offset("z");
    const xyz = new Float32Array(3 * count);
    for (let i = 0; i < count; i++) {
      const at = i * message.point_stride;
      xyz[3 * i] = view.getFloat32(at + x, true);
      xyz[3 * i + 1] = view.getFloat32(at + y, true);
      xyz[3 * i + 2] = view.getFloat32(at + z, true);
    }
    if (!this.points) {
      this.points = new THREE.Points(new THREE.BufferGeometry(),
        new THREE.PointsMaterial({ size: 0.008, color: "#5f8fbf", sizeAttenuation: true }));
      this.points.frustumCulled = false;
      const frame = this.frame(message.frame_id);
      this.layers.get("cloud")!.add(frame);
      frame.add(this.points);
    }
    this.points.geometry.dispose();
    this.points.geometry = new THREE.BufferGeometry();
    this.points.geometry.setAttribute("position", new THREE.BufferAttribute(xyz, 3));
  }

  /** The collision world: its boxes as cells. */
  map(message: SceneUpdate): void {
    this.touch();
    this.clear("map");
    this.clear("unseen");
    for (const entity of message.entities) {
      const unseen = entity.id === "hidden";
      this.layers.get(unseen ? "unseen" : "map")!.add(cellsOf(entity, unseen ? 1 : 0.85));
    }
  }

  /** Everybody near the arm, as boxes. */
  bodies(message: SceneUpdate): void {
    if (message.entities.length > 0 || this.layers.get("people")!.children.length > 0) this.touch();
    this.clear("people");
    for (const entity of message.entities) this.layers.get("people")!.add(objectOf(entity));
  }

  update(message: SceneUpdate): void {
    this.touch();
    for (const gone of message.deletions)
      for (const name of OF_SCENE) {
        const group = this.layers.get(name)!;
        for (const child of [...group.children])
          if (!this.stays(child) && (gone.type === 1 || child.name === gone.id)) { dispose(child); group.remove(child); }
      }
    for (const entity of message.entities) {
      if (entity.id === "path") continue; // palm_path draws it, with what is behind
      const object = objectOf(entity);
      this.layers.get(layerOf(entity.id))!.add(object);
      const cube = entity.id === "target" ? object.children[0] : undefined;
      if (!cube || !entity.cubes[0]) continue;
      this.focus.copy(cube.position);
      cube.updateMatrix();
      this.restBox = cube.matrix.clone();
      this.motion.seen(entity.cubes[0].pose);
      cube.matrix.decompose(this.rest.position, this.rest.quaternion, this.rest.scale);
    }
  }

  private stays(child: THREE.Object3D): boolean {
    return child === this.robot.ghost || child === this.palm.group || child === this.caption || child === this.rest;
  }

  select(id: number | null): void {
    this.touch();
    const found = this.layers.get("candidates")!.children.find((c) => c.userData.candidate === id);
    this.marker.visible = found !== undefined;
    const arrow = found?.children[0];
    if (arrow) this.marker.position.copy(arrow.position);
  }

  private frame(name: string): THREE.Group {
    let frame = this.frames.get(name);
    if (!frame) {
      frame = new THREE.Group();
      this.frames.set(name, frame);
    }
    return frame;
  }

  private clear(layer: Layer): void {
    const group = this.layers.get(layer)!;
    for (const child of [...group.children]) {
      if (this.stays(child)) continue;
      dispose(child);
      group.remove(child);
      if (layer === "cloud") this.points = null;
    }
  }

  private side(key: string): void {
    const from: Record<string, [number, number, number]> = {
      "1": [1.9, -2.3, 1.7], "2": [0.7, -3, 0.5], "3": [3.4, 0, 0.5], "4": [0.7, -0.01, 3.2],
    };
    const p = from[key];
    if (!p) return;
    this.camera.position.set(...p);
    this.controls?.target.copy(this.focus);
  }

  /** Turns the camera about what it looks at (rad). */
  private orbit(turn: number, tilt: number): void {
    const way = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target)
      .applyAxisAngle(new THREE.Vector3(1, 0, 0), -Math.PI / 2));
    way.theta += turn;
    way.phi = Math.min(Math.PI - 0.05, Math.max(0.05, way.phi + tilt));
    this.camera.position.setFromSpherical(way).applyAxisAngle(new THREE.Vector3(1, 0, 0), Math.PI / 2).add(this.controls.target);
  }

  private zoom(by: number): void {
    this.camera.position.sub(this.controls.target).multiplyScalar(by).add(this.controls.target);
  }

  private pick(event: MouseEvent): void {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    const ray = new THREE.Raycaster();
    ray.setFromCamera(at, this.camera);
    for (const hit of ray.intersectObjects(this.layers.get("candidates")!.children, true)) {
      for (let object: THREE.Object3D | null = hit.object; object; object = object.parent)
        if (object.userData.candidate !== undefined) return this.onPick(object.userData.candidate as number);
    }
  }

  /** To the place that the page gives it. */
  private fit(): void {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const ratio = this.renderer.getPixelRatio();
    if (this.canvas.width === Math.floor(w * ratio) && this.canvas.height === Math.floor(h * ratio)) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / Math.max(1, h);
    this.camera.updateProjectionMatrix();
  }
}
