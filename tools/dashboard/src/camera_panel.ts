// What the camera sees, in depth, with what the program found drawn over it: object, partner, chosen grasp, path to fly.

import * as THREE from "three";
import { type Calibration, type RawImage, type Transform, bytesOf } from "./messages";
import type { Painter } from "./pace";

const NEAR_MM = 500, FAR_MM = 3000;
const BOX_EDGES = [0, 1, 1, 3, 3, 2, 2, 0, 4, 5, 5, 7, 7, 6, 6, 4, 0, 4, 1, 5, 2, 6, 3, 7];

/** What stands over the picture, in world. */
export interface Overlay {
  box: THREE.Matrix4 | null;  // of a cube of edge one
  partner: THREE.Vector3 | null;
  grasp: THREE.Vector3 | null;
  path: THREE.Vector3[];
}

export class CameraPanel implements Painter {
  private calibration: Calibration | null = null;
  private fromWorld: THREE.Matrix4 | null = null;
  private picture = document.createElement("canvas");
  private hasPicture = false;

  private stale = false;

  constructor(private words: HTMLElement, private canvas: HTMLCanvasElement, private overlay: () => Overlay) { this.reset(); }

  reset(): void {
    this.hasPicture = false;
    this.canvas.hidden = true;
    this.words.textContent = "no picture yet";
  }

  model(calibration: Calibration): void { this.calibration = calibration; }

  pose(t: Transform): void {
    this.fromWorld = new THREE.Matrix4().compose(new THREE.Vector3(t.translation.x, t.translation.y, t.translation.z),
      new THREE.Quaternion(t.rotation.x, t.rotation.y, t.rotation.z, t.rotation.w), new THREE.Vector3(1, 1, 1)).invert();
  }

  show(image: RawImage): void {
    const bytes = bytesOf(image.data);
    const fits = image.encoding === "16UC1" && image.width > 0 && image.width <= 4096 && image.height > 0 &&
      image.height <= 4096 && bytes.length >= 2 * image.width * image.height;
    if (!fits) return;
    this.picture.width = image.width;
    this.picture.height = image.height;
    const context = this.picture.getContext("2d")!, pixels = context.createImageData(image.width, image.height);
    for (let i = 0; i < image.width * image.height; i++) {
      const mm = bytes[2 * i]! | (bytes[2 * i + 1]! << 8);
      const far = Math.min(1, Math.max(0, (mm - NEAR_MM) / (FAR_MM - NEAR_MM)));
      const grey = mm === 0 ? 0 : Math.round(245 - 200 * far); // near is bright, nothing is black
      pixels.data.set([grey, grey, mm === 0 ? 0 : grey, 255], 4 * i);
    }
    context.putImageData(pixels, 0, 0);
    this.stale = true;
    if (!this.hasPicture) this.words.textContent = "near is bright, black was not measured";
    this.hasPicture = true;
    this.canvas.hidden = false;
  }

  /** What is over the picture has moved. */
  touch(): void { this.stale = true; }
  wants(): boolean { return this.stale && this.hasPicture; }

  draw(): void {
    this.stale = false;
    const overlay = this.overlay();
    const { width, height } = this.picture;
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const to = this.canvas.getContext("2d")!;
    to.drawImage(this.picture, 0, 0);
    const scale = this.calibration ? width / this.calibration.width : 0;
    if (scale === 0 || !this.fromWorld) return;
    const pixel = (p: THREE.Vector3): [number, number] | null => {
      const c = p.clone().applyMatrix4(this.fromWorld!), K = this.calibration!.K;
      return c.z <= 0.05 ? null : [scale * (K[0]! * c.x / c.z + K[2]!), scale * (K[4]! * c.y / c.z + K[5]!)];
    };
    const line = (points: THREE.Vector3[], colour: string, dash: number[], pairs?: number[]) => {
      const at = points.map(pixel), order = pairs ?? points.slice(1).flatMap((_, i) => [i, i + 1]);
      for (const [stroke, thickness] of [["#000", 4], [colour, 2]] as const) { // dark rim: seen on near and far alike
        to.strokeStyle = stroke;
        to.lineWidth = thickness;
        to.setLineDash(dash);
        to.beginPath();
        for (let i = 0; i + 1 < order.length; i += 2) {
          const a = at[order[i]!], b = at[order[i + 1]!];
          if (a && b) { to.moveTo(...a); to.lineTo(...b); }
        }
        to.stroke();
      }
    };
    const mark = (place: THREE.Vector3, colour: string, word: string) => {
      const at = pixel(place);
      if (!at) return;
      to.setLineDash([]);
      for (const [stroke, thickness] of [["#000", 5], [colour, 3]] as const) {
        to.strokeStyle = stroke;
        to.lineWidth = thickness;
        to.beginPath();
        to.arc(...at, 7, 0, 7);
        to.stroke();
      }
      to.font = "600 13px sans-serif";
      to.strokeStyle = "#000";
      to.lineWidth = 4;
      to.strokeText(word, at[0] + 11, at[1] + 4);
      to.fillStyle = "#fff";
      to.fillText(word, at[0] + 11, at[1] + 4);
    };
    if (overlay.box) {
      const corners = [...Array(8).keys()].map((i) =>
        new THREE.Vector3((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, (i >> 2) - 0.5).applyMatrix4(overlay.box!));
      line(corners, "#e69f00", [], BOX_EDGES);
    }
    line(overlay.path, "#35c795", [6, 4]);
    if (overlay.grasp) mark(overlay.grasp, "#35c795", "grasp");
    if (overlay.partner) mark(overlay.partner, "#f2a6d0", "partner");
  }
}
