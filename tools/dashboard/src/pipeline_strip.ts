// The states that the task went through, each with its reason and how long it took; the last one is where it is.

import type { TaskChange, TaskStatus } from "./messages";
import { escaped, seconds } from "./words";

const NOMINAL = ["observe", "await-partner", "decide", "plan", "approach", "close", "verify", "await-ready", "lift", "hold",
  "lower", "release", "retreat", "done"];
const BAD_END = ["refused", "aborted", "stopped", "halt", "contact", "pause", "yield", "back-off"];

export class PipelineStrip {
  private changes: TaskChange[] = [];

  constructor(private list: HTMLElement) { this.draw(0); }

  reset(): void { this.changes = []; this.draw(0); }

  change(change: TaskChange): void {
    const last = this.changes[this.changes.length - 1];
    if (last && last.t === change.t && last.state === change.state) return; // sent again after a reconnect
    this.changes.push(change);
    this.draw(change.t);
  }

  status(status: TaskStatus): void {
    const now = this.list.querySelector<HTMLElement>("[aria-current] .age");
    if (now) now.textContent = seconds(status.in_state_s);
  }

  private draw(now: number): void {
    const items: string[] = [];
    this.changes.forEach((change, i) => {
      const next = this.changes[i + 1];
      const current = i === this.changes.length - 1;
      const kind = BAD_END.includes(change.state) ? "bad" : current ? "now" : "past";
      items.push(`<li class="${kind}" ${current ? 'aria-current="step"' : ""} title="${escaped(change.because)}">` +
        `<b>${escaped(change.state)}</b><span class="age">${seconds((next ? next.t : now) - change.t)}</span></li>`);
    });
    const here = this.changes[this.changes.length - 1]?.state;
    const at = here === undefined ? -1 : NOMINAL.indexOf(here);
    if (here === undefined || at >= 0)
      for (const state of NOMINAL.slice(at + 1)) items.push(`<li class="to-come"><b>${state}</b></li>`);
    this.list.innerHTML = items.join("");
    const current = this.list.querySelector<HTMLElement>("[aria-current]");
    if (current) this.list.scrollLeft = current.offsetLeft - this.list.clientWidth / 2;
  }
}
