// The grasps with their verdicts. One of them can be chosen, by click, in the picture or with the arrow keys, and says why.

import type { Candidate, Decision } from "./messages";
import { escaped, percent } from "./words";

const ORDER = ["chosen", "ok", "near-partner", "over-limit", "unstable", "unreachable", "collision", "too-wide"];

export class ChoicePanel {
  onSelect: (id: number | null) => void = () => {};
  private rows: Candidate[] = [];
  private selected: number | null = null;

  constructor(private because: HTMLElement, private table: HTMLElement, private reason: HTMLElement) {
    table.addEventListener("click", (event) => {
      const row = (event.target as HTMLElement).closest<HTMLElement>("[data-id]");
      if (row) this.select(Number(row.dataset.id));
    });
    table.addEventListener("keydown", (event) => {
      const step = event.key === "ArrowDown" ? 1 : event.key === "ArrowUp" ? -1 : 0;
      if (step === 0 || this.rows.length === 0) return;
      event.preventDefault();
      const at = this.rows.findIndex((c) => c.id === this.selected);
      const next = this.rows[Math.min(this.rows.length - 1, Math.max(0, at + step))];
      if (next) this.select(next.id);
    });
  }

  reset(): void {
    this.rows = [];
    this.selected = null;
    this.because.textContent = "no decision yet";
    this.table.innerHTML = "";
    this.reason.textContent = "";
  }

  show(decision: Decision): void {
    const share = decision.share_text ?? "";
    this.because.textContent = decision.because + (share && !decision.because.includes(share) ? `; ${share}` : "");
    const rank = (c: Candidate) => ORDER.indexOf(c.verdict) * 1e9 + (c.cost ?? 1e8);
    this.rows = [...decision.candidates].sort((a, b) => rank(a) - rank(b) || a.id - b.id);
    const rows = this.rows.map((c) =>
      `<tr data-id="${c.id}"><td>${c.id}</td><td><span class="verdict ${c.verdict}">${escaped(c.verdict)}</span></td>` +
      `<td>${escaped(c.kind)}</td><td>${percent(c.share)}</td><td>${c.cost === null ? "" : c.cost.toPrecision(4)}</td></tr>`);
    this.table.innerHTML =
      `<table><thead><tr><th>#</th><th>verdict</th><th>kind</th><th>share</th><th>cost</th></tr></thead><tbody>` +
      rows.join("") + `</tbody></table>`;
    if (this.selected !== null) this.select(this.selected);
    else if (decision.chosen !== null) this.mark(decision.chosen);
  }

  select(id: number): void {
    const candidate = this.rows.find((c) => c.id === id);
    if (!candidate) return;
    this.selected = id;
    this.mark(id);
    this.reason.textContent = `Grasp ${id}: ${candidate.verdict}. ${candidate.because || "nothing stands against it"}`;
    this.onSelect(id);
  }

  private mark(id: number): void {
    for (const row of this.table.querySelectorAll<HTMLElement>("[data-id]")) {
      const here = Number(row.dataset.id) === id;
      row.classList.toggle("selected", here);
      if (here) row.scrollIntoView({ block: "nearest" });
    }
  }
}
