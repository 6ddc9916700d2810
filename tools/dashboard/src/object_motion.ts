// Where the object is now, against where it was seen at rest: from its transform where the run publishes one, else
// straight up by the height of the palm. Drawn at every picture of the screen, between the messages.

import * as THREE from "three";
import type { Pose, Transform } from "./messages";

/** Time in which a picture follows a message (s): about the distance of two messages. */
const FOLLOWS_S = 0.05;
/** An older pose of the object says nothing about a palm that goes on (s). */
const FRESH_S = 0.5;
/** Further than a lift goes between two messages: a jump in the recording, not a motion (m). */
const JUMP_M = 0.1;

export class ObjectMotion {
  /** Applied to whatever was drawn where the object rested. */
  readonly matrix = new THREE.Matrix4();
  private rest = new THREE.Matrix4();
  private shift = new THREE.Vector3();
  private turn = new THREE.Quaternion();
  private wantedShift = new THREE.Vector3();
  private wantedTurn = new THREE.Quaternion();
  private posed_s = -Infinity;

  reset(): void {
    this.posed_s = -Infinity;
    this.wantedShift.set(0, 0, 0);
    this.wantedTurn.identity();
    this.jump();
  }

  /** The object's box as it was seen at rest. */
  seen(pose: Pose): void { this.rest.copy(matrixOf(pose.position, pose.orientation)); }

  /** The pose of that box, as a frame shows it. */
  pose(now: Transform, at_s: number): void {
    this.posed_s = at_s;
    const moved = matrixOf(now.translation, now.rotation).multiply(this.rest.clone().invert());
    moved.decompose(this.wantedShift, this.wantedTurn, new THREE.Vector3());
  }

  /** Of the palm over where it closed (m); null: nothing is held, and the object stays where it was seen last. */
  height(m: number | null, at_s: number): void {
    if (Math.abs(at_s - this.posed_s) < FRESH_S || (m === null && this.posed_s > -Infinity)) return;
    this.wantedTurn.identity();
    this.wantedShift.set(0, 0, m ?? 0);
  }

  /** Without the way in between. */
  jump(): void {
    this.shift.copy(this.wantedShift);
    this.turn.copy(this.wantedTurn);
    this.compose();
  }

  /** What is drawn is where the last message says. */
  get settled(): boolean {
    return this.shift.distanceTo(this.wantedShift) < 1e-5 && this.turn.angleTo(this.wantedTurn) < 1e-4;
  }

  tick(dt_s: number): void {
    if (this.settled) return;
    if (this.shift.distanceTo(this.wantedShift) > JUMP_M) return this.jump();
    const part = 1 - Math.exp(-dt_s / FOLLOWS_S);
    this.shift.lerp(this.wantedShift, part);
    this.turn.slerp(this.wantedTurn, part);
    this.compose();
  }

  private compose(): void { this.matrix.compose(this.shift, this.turn, new THREE.Vector3(1, 1, 1)); }
}

function matrixOf(p: { x: number; y: number; z: number }, q: { x: number; y: number; z: number; w: number }): THREE.Matrix4 {
  return new THREE.Matrix4().compose(new THREE.Vector3(p.x, p.y, p.z), new THREE.Quaternion(q.x, q.y, q.z, q.w),
    new THREE.Vector3(1, 1, 1));
}
