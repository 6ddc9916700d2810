// The hand's tactile cells as they lie on it, and the force on each finger. Robots without such cells say so.

import type { Tactile } from "./messages";
import { escaped, figure } from "./words";

/** Cells per row of an array: a fingertip has eight rows of three, the palm 5, 7, 7, 5 (tools/telemetry/channels). */
const ROWS: Record<string, number[]> = { palm: [5, 7, 7, 5] };
const FINGERTIP = [3, 3, 3, 3, 3, 3, 3, 3];
/** Darkest cell (N/cm2). */
const FULL = 10;

export class HandPanel {
  private cells = new Map<string, HTMLElement[]>();
  private forces = new Map<string, HTMLElement>();

  constructor(private words: HTMLElement, private box: HTMLElement) { this.reset(); }

  reset(): void {
    this.words.textContent = "no tactile data: this hand has no cells, or none has spoken yet";
    this.box.innerHTML = "";
    this.cells.clear();
    this.forces.clear();
  }

  show(message: Tactile): void {
    const touched: string[] = [];
    for (const array of message.arrays) {
      if (!this.cells.has(array.name)) this.build(array.name);
      const max = Math.max(0, ...array.cells.map((c) => c ?? 0));
      this.cells.get(array.name)!.forEach((cell, i) => {
        const pressure = Math.max(0, array.cells[i] ?? 0);
        cell.style.setProperty("--press", Math.min(1, pressure / FULL).toFixed(2));
        cell.classList.toggle("absent", array.cells[i] === null || array.cells[i] === undefined);
      });
      const force = array.force_n === null ? "" : `${figure(array.force_n, 1)} N`;
      this.forces.get(array.name)!.textContent = force || `${figure(max, 1)} N/cm²`;
      if (max > 0.5 || (array.force_n ?? 0) > 0.5) touched.push(array.name);
    }
    this.words.textContent = touched.length > 0 ? `touches with ${touched.join(", ")}` : "touches nothing";
  }

  private build(name: string): void {
    const rows = ROWS[name] ?? FINGERTIP, widest = Math.max(...rows);
    const figureBox = document.createElement("figure");
    figureBox.innerHTML = `<figcaption>${escaped(name)} <b></b></figcaption>`;
    const list: HTMLElement[] = [];
    const grid = document.createElement("div");
    grid.className = "cells";
    grid.setAttribute("aria-hidden", "true"); // the words beside it say the same
    for (const count of rows) {
      const row = document.createElement("div");
      row.style.width = `${100 * count / widest}%`;
      for (let i = 0; i < count; i++) {
        const cell = document.createElement("i");
        row.append(cell);
        list.push(cell);
      }
      grid.append(row);
    }
    figureBox.append(grid);
    this.box.append(figureBox);
    this.cells.set(name, list);
    this.forces.set(name, figureBox.querySelector("b")!);
  }
}
