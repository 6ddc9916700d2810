// The scene: robot, cloud, map, ground, target, surfaces, candidates, partner, people, path. z is up, metres, the robot's base frame.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { type PointCloud, type SceneUpdate, type Transform, bytesOf } from "./messages";
import { cellsOf, dispose, objectOf, place } from "./scene_entities";
import { RobotView } from "./robot_view";

const LAYERS = ["robot", "cloud", "map", "unseen", "ground", "target", "surfaces", "candidates", "partner", "people",
  "gripper", "path"] as const;
type Layer = (typeof LAYERS)[number];
/** Not there at first: they cover what is more asked for. */
const HIDDEN: Layer[] = ["unseen", "surfaces"];
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

export class SceneView {
  onPick: (id: number) => void = () => {};
  readonly robot = new RobotView();

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
    this.layers.get("path")!.add(this.robot.ghost);
    this.marker.visible = false;
    this.marker.renderOrder = 10;
    this.scene.add(this.marker);
    canvas.addEventListener("click", (event) => this.pick(event));
    canvas.addEventListener("keydown", (event) => {
      if ("1234".includes(event.key)) this.side(event.key);
      if (event.key === "f") this.controls.target.copy(this.focus);
    });
    const draw = (now: number) => {
      this.fit();
      this.robot.tick(now / 1000);
      this.controls.update();
      if (this.marker.visible) this.marker.lookAt(this.camera.position);
      this.renderer.render(this.scene, this.camera);
      requestAnimationFrame(draw);
    };
    requestAnimationFrame(draw);
  }

  background(colour: string): void { this.scene.background = new THREE.Color(colour); }

  reset(): void {
    for (const name of LAYERS)
      if (name !== "robot") this.clear(name);
    this.robot.show(null);
    this.marker.visible = false;
  }

  transforms(list: Transform[]): void {
    for (const t of list) {
      const frame = this.frame(t.child_frame_id);
      place(frame, { position: t.translation, orientation: t.rotation });
    }
  }

  cloud(message: PointCloud): void {
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
    this.clear("map");
    this.clear("unseen");
    for (const entity of message.entities) {
      const unseen = entity.id === "hidden";
      this.layers.get(unseen ? "unseen" : "map")!.add(cellsOf(entity, unseen ? 1 : 0.85));
    }
  }

  /** Everybody near the arm, as boxes. */
  bodies(message: SceneUpdate): void {
    this.clear("people");
    for (const entity of message.entities) this.layers.get("people")!.add(objectOf(entity));
  }

  update(message: SceneUpdate): void {
    for (const gone of message.deletions)
      for (const name of OF_SCENE) {
        const group = this.layers.get(name)!;
        for (const child of [...group.children])
          if (child !== this.robot.ghost && (gone.type === 1 || child.name === gone.id)) { dispose(child); group.remove(child); }
      }
    for (const entity of message.entities) {
      const object = objectOf(entity);
      this.layers.get(layerOf(entity.id))!.add(object);
      if (entity.id === "target") {
        const cube = object.children[0];
        if (cube) this.focus.copy(cube.position);
      }
    }
  }

  select(id: number | null): void {
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
      if (child === this.robot.ghost) continue;
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

  private fit(): void {
    const { clientWidth: w, clientHeight: h } = this.canvas;
    const ratio = this.renderer.getPixelRatio();
    if (this.canvas.width === Math.floor(w * ratio) && this.canvas.height === Math.floor(h * ratio)) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / Math.max(1, h);
    this.camera.updateProjectionMatrix();
  }
}
