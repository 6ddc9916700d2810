// The palm's path: what it has flown (a thin line that grows) and what is still to fly (green, with beads: told apart without colour).

import * as THREE from "three";

const KEPT = 2000;
const STEP_M = 0.004; // nearer to the last point is no new one
const JUMP_M = 0.3;   // no palm goes that far between two messages

export class PalmPath {
  readonly group = new THREE.Group();
  private flown: THREE.Vector3[] = [];
  private toFly: THREE.Vector3[] = [];
  private passed = 0;
  private behind = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: "#d55e00" }));
  private ahead = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: "#009e73" }));
  private beads = new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ color: "#009e73", size: 0.014 }));

  constructor() {
    for (const part of [this.behind, this.ahead, this.beads]) {
      part.frustumCulled = false;
      this.group.add(part);
    }
  }

  reset(): void {
    this.flown = [];
    this.plan(null);
    this.draw();
  }

  /** Points of the palm, metres in world. */
  plan(points: number[][] | null): void {
    this.toFly = (points ?? []).map(([x = 0, y = 0, z = 0]) => new THREE.Vector3(x, y, z));
    this.passed = 0;
    this.draw();
  }

  /** The plan is behind it. True: it was not before. */
  arrived(): boolean {
    if (this.passed >= this.toFly.length) return false;
    this.passed = this.toFly.length;
    this.draw();
    return true;
  }

  palm(at: THREE.Vector3): void {
    const last = this.flown[this.flown.length - 1];
    if (last && last.distanceTo(at) < STEP_M) return;
    if (last && last.distanceTo(at) > JUMP_M) this.flown = [];
    this.flown.push(at.clone());
    if (this.flown.length > KEPT) this.flown.shift();
    while (this.passed + 1 < this.toFly.length &&
      this.toFly[this.passed + 1]!.distanceTo(at) <= this.toFly[this.passed]!.distanceTo(at)) this.passed++;
    this.draw();
  }

  get rest(): THREE.Vector3[] { return this.toFly.slice(this.passed); }
  get past(): THREE.Vector3[] { return this.flown; }

  private draw(): void {
    const set = (part: THREE.Line | THREE.Points, points: THREE.Vector3[]) => {
      part.geometry.dispose();
      part.geometry = new THREE.BufferGeometry().setFromPoints(points);
    };
    set(this.behind, this.flown);
    set(this.ahead, this.rest);
    set(this.beads, this.rest);
  }
}
