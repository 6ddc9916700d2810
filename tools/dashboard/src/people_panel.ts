// Who is near the arm, how fast it may be because of that, and the force on its hand against what would stop it.

import uPlot from "uplot";
import type { TaskStatus } from "./messages";
import type { Painter } from "./pace";
import { forceWords, percent, separationWords } from "./words";

const KEPT = 3600;
const HEIGHT = 84;

export class PeoplePanel implements Painter {
  private t: number[] = [];
  private distance: (number | null)[] = [];
  private stops: number[] = [];
  private slows: number[] = [];
  private scale: number[] = [];
  private plot: uPlot;
  private stale = false;

  constructor(private near: HTMLElement, private felt: HTMLElement, private box: HTMLElement, private alarm: HTMLElement) {
    this.plot = this.build();
    new ResizeObserver(() => this.plot.setSize({ width: this.width(), height: HEIGHT })).observe(box);
  }

  wants(): boolean { return this.stale; }

  draw(): void {
    this.stale = false;
    this.plot.setData([this.t, this.distance, this.stops, this.slows, this.scale] as uPlot.AlignedData);
  }

  reset(): void {
    for (const list of [this.t, this.distance, this.stops, this.slows, this.scale]) list.length = 0;
    this.near.textContent = "nobody near the arm";
    this.felt.textContent = "";
    this.alarm.hidden = true;
    this.stale = true;
  }

  show(status: TaskStatus): void {
    const s = status.separation;
    if (!s) return; // of a recording from before there were any
    this.alarm.hidden = s.on;
    this.alarm.textContent = "Speed and separation monitoring is OFF: the arm notices nobody. It moves at T1 speed.";
    this.near.textContent = separationWords(s);
    this.near.className = s.waits ? "waits" : s.speed_scale < 1 ? "slowed" : "";
    this.felt.textContent = status.force ? forceWords(status.force) : "";
    this.felt.className = status.force?.exceeded ? "waits" : "";
    const last = this.t[this.t.length - 1];
    if (last !== undefined && status.t <= last) return; // sent again after a reconnect
    this.t.push(status.t);
    this.distance.push(s.distance_m === null ? null : Math.max(0, s.distance_m));
    this.stops.push(s.hold_distance_m);
    this.slows.push(s.slow_distance_m);
    this.scale.push(s.speed_scale);
    if (this.t.length > KEPT) for (const list of [this.t, this.distance, this.stops, this.slows, this.scale]) list.shift();
    this.stale = true;
  }

  /** New colours. */
  rebuild(): void {
    this.plot.destroy();
    this.plot = this.build();
    this.stale = true;
  }

  private width(): number { return Math.max(200, this.box.clientWidth); }

  private build(): uPlot {
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const axis: uPlot.Axis = {
      stroke: colour("--text"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line") },
      space: 20, size: 46, font: "11px sans-serif",
    };
    return new uPlot({
      width: this.width(), height: HEIGHT, legend: { show: false }, cursor: { drag: { x: false, y: false } },
      scales: { x: { time: false }, y: { range: [0, 1.5] }, speed: { range: [0, 1.02] } },
      axes: [{ ...axis, space: 50, size: 28, values: (_, ticks) => ticks.map((v) => `${v} s`) }, axis,
        { ...axis, scale: "speed", side: 1, grid: { show: false }, values: (_, ticks) => ticks.map((v) => percent(v)) }],
      series: [{ label: "s" },
        { label: "distance", stroke: colour("--accent"), width: 2 },
        { label: "stops", stroke: colour("--bad"), width: 1, dash: [4, 4] },
        { label: "slows", stroke: colour("--warn"), width: 1, dash: [4, 4] },
        { label: "speed", scale: "speed", stroke: colour("--good"), width: 2 }],
    }, [[], [], [], [], []], this.box);
  }
}
