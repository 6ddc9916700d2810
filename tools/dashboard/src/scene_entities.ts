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
const BALL = new THREE.SphereGeometry(0.5, 24, 16);
const ROUND = new THREE.CylinderGeometry(0.5, 0.5, 1, 32).rotateX(Math.PI / 2);
const SHAFT = new THREE.CylinderGeometry(0.5, 0.5, 1, 12).rotateZ(-Math.PI / 2).translate(0.5, 0, 0);
const HEAD = new THREE.ConeGeometry(0.5, 1, 16).rotateZ(-Math.PI / 2).translate(0.5, 0, 0);

function solid(geometry: THREE.BufferGeometry, s: Solid): THREE.Mesh {
  const mesh = new THREE.Mesh(geometry, material(s.color));
  place(mesh, s.pose);
  mesh.scale.set(s.size.x, s.size.y, s.size.z);
  return mesh;
}

export function objectOf(entity: Entity): THREE.Group {
  const group = new THREE.Group();
  group.name = entity.id;
  for (const s of entity.cubes) group.add(solid(BOX, s));
  for (const s of entity.spheres) group.add(solid(BALL, s));
  for (const s of entity.cylinders) group.add(solid(ROUND, s));
  for (const a of entity.arrows) {
    const arrow = new THREE.Group();
    place(arrow, a.pose);
    const shaft = new THREE.Mesh(SHAFT, material(a.color)), head = new THREE.Mesh(HEAD, material(a.color));
    shaft.scale.set(a.shaft_length, a.shaft_diameter, a.shaft_diameter);
    head.position.x = a.shaft_length;
    head.scale.set(a.head_length, a.head_diameter, a.head_diameter);
    arrow.add(shaft, head);
    group.add(arrow);
  }
  for (const l of entity.lines) {
    const points = l.points.map((p) => new THREE.Vector3(p.x, p.y, p.z));
    const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(points),
      new THREE.LineBasicMaterial({ color: new THREE.Color(l.color.r, l.color.g, l.color.b) }));
    place(line, l.pose);
    group.add(line);
  }
  const id = /^candidate (\d+)$/.exec(entity.id);
  if (id) group.userData.candidate = Number(id[1]);
  return group;
}

/** Frees what a group holds for itself; the shapes are shared. */
export function dispose(group: THREE.Object3D): void {
  group.traverse((object) => {
    if (object instanceof THREE.Line) object.geometry.dispose();
    if (object instanceof THREE.Mesh || object instanceof THREE.Line) (object.material as THREE.Material).dispose();
  });
}
