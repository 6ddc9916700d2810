// The robot from its own URDF, where it is, and where its way will lead it (the ghost).

import * as THREE from "three";
import URDFLoader, { type URDFRobot } from "urdf-loader";
import type { JointStates, Plan } from "./messages";

const ARM = ["arm_1", "arm_2", "arm_3", "arm_4", "arm_5", "arm_6", "arm_7"];
const GHOST_SECONDS = 4;
/** A joint that turns by less moves nothing by a pixel (rad). */
const SEEN_RAD = 2e-4;
const AFTER = ["close", "verify", "await-ready", "lift", "hold", "lower", "pause", "yield", "release", "retreat",
  "done", "stopped"];

export class RobotView {
  /** Where the palm is now, in world. */
  onPalm: (at: THREE.Vector3) => void = () => {};
  readonly group = new THREE.Group();
  readonly ghost = new THREE.Group();
  private robot: URDFRobot | null = null;
  private shadow: URDFRobot | null = null;
  private plan: Plan | null = null;
  private last: JointStates | null = null;
  private arrived = false;

  async load(url: string): Promise<void> {
    const answer = await fetch(url);
    if (!answer.ok) return;
    const text = await answer.text();
    this.robot = this.parse(text, (m) => { m.color.set("#e08a2c"); });
    this.shadow = this.parse(text, (m) => {
      m.color.set("#009e73");
      m.transparent = true;
      m.opacity = 0.25;
      m.depthWrite = false;
    });
    this.group.add(this.robot);
    this.ghost.add(this.shadow);
    this.ghost.visible = this.plan !== null && !this.arrived;
    if (this.last) this.pose(this.last);
  }

  /** True: what is seen has changed. */
  joints(state: JointStates): boolean {
    const moved = state.joints.some((joint, i) => Math.abs(joint.position - (this.last?.joints[i]?.position ?? Infinity)) > SEEN_RAD);
    if (!moved) return false;
    this.last = state;
    this.pose(state);
    return true;
  }

  private pose(state: JointStates): void {
    for (const joint of state.joints) this.robot?.setJointValue(joint.name, joint.position);
    const palm = this.robot?.links["palm"];
    if (palm) this.onPalm(palm.getWorldPosition(new THREE.Vector3()));
  }

  show(plan: Plan | null): void {
    this.plan = plan && plan.postures.length > 1 ? plan : null;
    this.ghost.visible = this.plan !== null && !this.arrived;
  }

  /** From the closing hand on the way is behind it: then true. */
  state(word: string): boolean {
    this.arrived = AFTER.includes(word);
    this.ghost.visible = this.plan !== null && !this.arrived;
    return this.arrived;
  }

  /** Lets the ghost walk along the way, again and again. */
  tick(now_s: number): void {
    if (!this.plan || !this.shadow || !this.ghost.visible) return;
    const postures = this.plan.postures;
    const at = (now_s % GHOST_SECONDS) / GHOST_SECONDS * (postures.length - 1);
    const i = Math.min(postures.length - 2, Math.floor(at)), part = at - i;
    ARM.forEach((name, j) => {
      const a = postures[i]![j] ?? 0, b = postures[i + 1]![j] ?? 0;
      this.shadow!.setJointValue(name, a + part * (b - a));
    });
  }

  private parse(text: string, paint: (material: THREE.MeshLambertMaterial) => void): URDFRobot {
    const loader = new URDFLoader();
    loader.parseVisual = false;  // our robot's one geometry is the one that collides
    loader.parseCollision = true;
    const robot = loader.parse(text);
    robot.traverse((object) => {
      object.visible = true;
      if (!(object instanceof THREE.Mesh)) return;
      const material = new THREE.MeshLambertMaterial();
      paint(material);
      object.material = material;
    });
    return robot;
  }
}
