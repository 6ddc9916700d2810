// Entities of a SceneUpdate as three.js objects.

import * as THREE from "three";
import type { Colour, Entity, Pose, Solid } from "./messages";

function material(c: Colour): THREE.MeshLambertMaterial {
  return new THREE.MeshLambertMaterial({
    color: new THREE.Color(c.r, c.g, c.b), transparent: c.a < 1, opacity: c.a, depthWrite: c.a >= 1,
    side: THREE.DoubleSide,
  });
}

export function place(object: THREE.Object3D, pose: Pose): void {
  object.position.set(pose.position.x, pose.position.y, pose.position.z);
  const q = pose.orientation;
  object.quaternion.set(q.x, q.y, q.z, q.w);
}

const BOX = new THREE.BoxGeometry(1, 1, 1);
const EDGES = new THREE.EdgesGeometry(BOX);
const BALL = new THREE.SphereGeometry(0.5, 24, 16);
const ROUND = new THREE.CylinderGeometry(0.5, 0.5, 1, 32).rotateX(Math.PI / 2);
const SHAFT = new THREE.CylinderGeometry(0.5, 0.5, 1, 12).rotateZ(-Math.PI / 2).translate(0.5, 0, 0);
const HEAD = new THREE.ConeGeometry(0.5, 1, 16).rotateZ(-Math.PI / 2).translate(0.5, 0, 0);

/** The end of a candidate's arrow says its verdict by shape, for whom colours do not (choice_panel has the same as signs). */
const ENDS: Record<string, THREE.BufferGeometry> = {
  collision: cross(),
  unreachable: new THREE.TorusGeometry(0.5, 0.12, 8, 24).rotateY(Math.PI / 2).translate(0.5, 0, 0),
  "too-wide": new THREE.BoxGeometry(0.35, 1.7, 0.35).translate(0.5, 0, 0),
  unstable: new THREE.TetrahedronGeometry(0.7).translate(0.5, 0, 0),
  "over-limit": new THREE.BoxGeometry(0.9, 0.9, 0.9).translate(0.5, 0, 0),
  "near-partner": new THREE.SphereGeometry(0.5, 16, 12).translate(0.5, 0, 0),
};

/** Two bars, one across the other, across the arrow's axis. */
function cross(): THREE.BufferGeometry {
  const shape = new THREE.Shape();
  const [thin, long] = [0.16, 0.75];
  const corners = [[thin, thin], [long, thin], [long, -thin], [thin, -thin], [thin, -long], [-thin, -long], [-thin, -thin],
    [-long, -thin], [-long, thin], [-thin, thin], [-thin, long], [thin, long]];
  corners.forEach(([x, y], i) => (i === 0 ? shape.moveTo(x!, y!) : shape.lineTo(x!, y!)));
  return new THREE.ExtrudeGeometry(shape, { depth: 0.3, bevelEnabled: false }).rotateZ(Math.PI / 4).rotateY(Math.PI / 2).translate(0.3, 0, 0);
}

function solid(geometry: THREE.BufferGeometry, s: Solid): THREE.Mesh {
  const mesh = new THREE.Mesh(geometry, material(s.color));
  place(mesh, s.pose);
  mesh.scale.set(s.size.x, s.size.y, s.size.z);
  return mesh;
}

/** Entities that are looked for first wear their name. */
const LABELS: Record<string, string> = { partner: "partner", gripper: "chosen" };

const LABEL_FONT = "600 44px sans-serif";

/** A word above a place, always turned to who looks and of the same size. */
export function label(word: string, pose: Pose, c: Colour): THREE.Sprite {
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d")!;
  context.font = LABEL_FONT;
  const width = Math.max(256, Math.min(1024, Math.ceil(context.measureText(word).width) + 40));
  canvas.width = width;
  canvas.height = 64;
  context.fillStyle = "rgba(255, 255, 255, 0.88)";
  context.beginPath();
  context.roundRect(4, 4, width - 8, 56, 20);
  context.fill();
  context.font = LABEL_FONT; // forgotten with the new size
  context.textAlign = "center";
  context.fillStyle = `#${new THREE.Color(c.r, c.g, c.b).multiplyScalar(0.25).getHexString()}`;
  context.fillText(word, width / 2, 47, width - 20);
  const texture = new THREE.CanvasTexture(canvas);
  texture.colorSpace = THREE.SRGBColorSpace;
  const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ map: texture, depthTest: false, sizeAttenuation: false }));
  sprite.position.set(pose.position.x, pose.position.y, pose.position.z + 0.17);
  sprite.scale.set(0.025 * width / 64, 0.025, 1);
  sprite.renderOrder = 6;
  return sprite;
}

export function objectOf(entity: Entity): THREE.Group {
  const group = new THREE.Group();
  group.name = entity.id;
  for (const s of entity.cubes) {
    const box = solid(BOX, s);
    group.add(box);
    // what encloses something is drawn by its edges: the filling would hide it
    if (entity.id === "ground") (box.material as THREE.Material).opacity = 0.12;
    if (s.color.a > 0.25 || entity.id === "ground") continue;
    // but what is carried is what one looks for
    (box.material as THREE.MeshLambertMaterial).opacity = entity.id === "target" ? 0.4 : 0.3 * s.color.a;
    const edges = new THREE.LineSegments(EDGES, new THREE.LineBasicMaterial({ color: (box.material as THREE.MeshLambertMaterial).color }));
    edges.position.copy(box.position);
    edges.quaternion.copy(box.quaternion);
    edges.scale.copy(box.scale);
    group.add(edges);
  }
  for (const s of entity.spheres) {
    const ball = solid(BALL, s);
    // small, and often inside of something
    (ball.material as THREE.Material).depthTest = false;
    ball.renderOrder = 5;
    group.add(ball);
  }
  for (const s of entity.cylinders) group.add(solid(ROUND, s));
  const end = ENDS[entity.metadata.find((m) => m.key === "verdict")?.value ?? ""] ?? HEAD;
  const axes = entity.id === "gripper" ? ["x", "y", "z"] : [];
  for (const [i, a] of entity.arrows.entries()) {
    const arrow = new THREE.Group();
    place(arrow, a.pose);
    const shaft = new THREE.Mesh(SHAFT, material(a.color)), head = new THREE.Mesh(end, material(a.color));
    shaft.scale.set(a.shaft_length, a.shaft_diameter, a.shaft_diameter);
    head.position.x = a.shaft_length;
    head.scale.set(a.head_length, a.head_diameter, a.head_diameter);
    arrow.add(shaft, head);
    group.add(arrow);
    const letter = axes[i];
    if (letter) {
      const tip = label(letter, a.pose, a.color);
      tip.position.set(a.shaft_length + 0.03, 0, 0);
      tip.scale.multiplyScalar(0.4);
      arrow.add(tip);
    }
  }
  for (const l of entity.lines) {
    const points = l.points.map((p) => new THREE.Vector3(p.x, p.y, p.z));
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({ color: new THREE.Color(l.color.r, l.color.g, l.color.b) }));
    place(line, l.pose);
    group.add(line);
  }
  const words = entity.metadata.find((m) => m.key === "label")?.value, box = entity.cubes[0];
  if (words && box) {
    const top = { ...box.pose, position: { ...box.pose.position, z: box.pose.position.z + box.size.z / 2 } };
    group.add(label(words, top, box.color));
  }
  const name = LABELS[entity.id], first = entity.spheres[0] ?? entity.arrows[0];
  if (name && first) group.add(label(name, first.pose, entity.cubes[0]?.color ?? first.color));
  const id = /^candidate (\d+)$/.exec(entity.id);
  if (id) group.userData.candidate = Number(id[1]);
  return group;
}

/** An entity of many boxes as one object: each box cut into the cells that it is made of, `size` of a cell's edge. */
export function cellsOf(entity: Entity, size: number): THREE.Object3D {
  const edge = Number(entity.metadata.find((m) => m.key === "cell_m")?.value ?? 0);
  const color = entity.cubes[0]?.color ?? { r: 0, g: 0, b: 0, a: 1 };
  const places: number[] = [], edges: number[] = [];
  for (const box of entity.cubes) {
    const length = [box.size.x, box.size.y, box.size.z], p = box.pose.position;
    // where nobody sees the joints, a box stays one
    const count = length.map((l) => (edge > 0 && size < 1 ? Math.max(1, Math.round(l / edge)) : 1));
    const step = length.map((l, i) => l / count[i]!);
    for (let z = 0; z < count[2]!; z++)
      for (let y = 0; y < count[1]!; y++)
        for (let x = 0; x < count[0]!; x++) {
          places.push(...[p.x, p.y, p.z].map((m, i) => m - length[i]! / 2 + ([x, y, z][i]! + 0.5) * step[i]!));
          edges.push(...step.map((s) => size * s));
        }
  }
  const mesh = new THREE.InstancedMesh(BOX, material(color), places.length / 3);
  const matrix = new THREE.Matrix4();
  for (let n = 0; n < mesh.count; n++) {
    matrix.makeScale(edges[3 * n]!, edges[3 * n + 1]!, edges[3 * n + 2]!);
    matrix.setPosition(places[3 * n]!, places[3 * n + 1]!, places[3 * n + 2]!);
    mesh.setMatrixAt(n, matrix);
  }
  mesh.name = entity.id;
  return mesh;
}

/** Frees what a group holds for itself; the shapes are shared. */
export function dispose(group: THREE.Object3D): void {
  group.traverse((object) => {
    if (object instanceof THREE.InstancedMesh) object.dispose();
    if (object instanceof THREE.Line && object.geometry !== EDGES) object.geometry.dispose();
    if (object instanceof THREE.Sprite) {
      object.material.map?.dispose();
      object.material.dispose();
    }
    if (object instanceof THREE.Mesh || object instanceof THREE.Line) (object.material as THREE.Material).dispose();
  });
}
