// Share, height and tilt over time.

import uPlot from "uplot";
import "uplot/dist/uPlot.min.css";
import type { Load } from "./messages";
import type { Painter } from "./pace";
import { loadWords, percent } from "./words";

const KEPT = 3600;
const HEIGHTS = [64, 88]; // the upper one leaves the time to the lower one

export class LoadPlots implements Painter {
  private t: number[] = [];
  private share: (number | null)[] = [];
  private predicted: (number | null)[] = [];
  private tilt: (number | null)[] = [];
  private height: (number | null)[] = [];
  private plots: uPlot[] = [];
  private stale = false;

  constructor(private words: HTMLElement, private shareBox: HTMLElement, private tiltBox: HTMLElement) {
    this.build();
    new ResizeObserver(() => this.resize()).observe(shareBox);
  }

  wants(): boolean { return this.stale; }

  draw(): void {
    this.stale = false;
    this.plots[0]?.setData([this.t, this.share, this.predicted] as uPlot.AlignedData);
    this.plots[1]?.setData([this.t, this.tilt, this.height] as uPlot.AlignedData);
  }

  reset(): void {
    for (const list of [this.t, this.share, this.predicted, this.tilt, this.height]) list.length = 0;
    this.words.textContent = "nothing carried yet";
    this.stale = true;
  }

  add(load: Load, atNs: bigint): void {
    const t = Number(atNs) / 1e9;
    if (this.t.length > 0 && t <= this.t[this.t.length - 1]!) return; // sent again after a reconnect
    this.t.push(t);
    this.share.push(load.share);
    this.predicted.push(load.share === null ? null : load.share_predicted);
    this.tilt.push(load.tilt_deg);
    this.height.push(load.height_m === null ? null : 100 * load.height_m);
    if (this.t.length > KEPT)
      for (const list of [this.t, this.share, this.predicted, this.tilt, this.height]) list.shift();
    this.stale = true;
    this.words.textContent = loadWords(load) ?? this.words.textContent;
  }

  /** New colours. */
  rebuild(): void {
    for (const plot of this.plots) plot.destroy();
    this.build();
    this.stale = true;
  }

  private build(): void {
    const style = getComputedStyle(document.documentElement);
    const colour = (name: string) => style.getPropertyValue(name).trim();
    const axis = (label: string): uPlot.Axis => ({
      label, space: 20, stroke: colour("--text"), grid: { stroke: colour("--line"), width: 1 }, ticks: { stroke: colour("--line") },
      size: 46, labelSize: 14, font: "11px sans-serif", labelFont: "11px sans-serif",
    });
    const time: uPlot.Axis = { ...axis(""), space: 50, size: 28, labelSize: 0, values: (_, ticks) => ticks.map((v) => `${v} s`) };
    const options = (row: number, box: HTMLElement, series: uPlot.Series[], axes: uPlot.Axis[], scales: uPlot.Scales): uPlot.Options => ({
      width: Math.max(200, box.clientWidth), height: HEIGHTS[row]!, series: [{ label: "s" }, ...series],
      axes: [row === 0 ? { ...time, size: 6, values: (_, ticks) => ticks.map(() => "") } : time, ...axes],
      scales: { x: { time: false }, ...scales }, legend: { show: false }, cursor: { drag: { x: false, y: false } },
    });
    this.plots = [
      new uPlot(options(0, this.shareBox, [
        { label: "robot's share", stroke: colour("--good"), width: 2 },
        { label: "predicted", stroke: colour("--muted"), width: 1, dash: [4, 4] },
      ], [{ ...axis("share"), values: (_, ticks) => ticks.map((v) => percent(v)) }], { y: { range: [0, 1] } }), [[], [], []], this.shareBox),
      new uPlot(options(1, this.tiltBox, [
        { label: "tilt °", stroke: colour("--warn"), width: 2 },
        { label: "height cm", stroke: colour("--accent"), width: 2 },
      ], [{ ...axis("° · cm") }], { y: { range: (_, low, high) => (low === null ? [0, 5] : [Math.min(0, low), Math.max(1, 1.1 * high)]) } }), [[], [], []], this.tiltBox),
    ];
  }

  private resize(): void {
    for (const [i, box] of [this.shareBox, this.tiltBox].entries())
      this.plots[i]?.setSize({ width: Math.max(200, box.clientWidth), height: HEIGHTS[i]! });
  }
}
