// A whole recording in the page, so that it can be stopped, searched and stepped through. The server hands it out as lines
// "TOPIC NANOSECONDS JSON" in the order of time (tools/log); a line is only parsed when it is shown.

import type { TaskChange, TaskStatus } from "./messages";

interface Entry { topic: string; at: bigint; text: string }
/** Of these all that were said before count, of the others the newest. */
const HISTORIES = ["/task/change", "/log", "/load", "/task/status"];
/** Of these none that was said before still holds. */
const MOMENTARY = ["/task/intent"];
const LOG_LINES = 300;

export class Recording {
  /** Shows one message. */
  onMessage: (topic: string, text: string, at: bigint) => void = () => {};
  /** Nothing that was shown holds any longer. */
  onReset: () => void = () => {};
  readonly begins: bigint;
  readonly ends: bigint;
  /** Of each state, the first moment that shows it. */
  readonly states: { at: bigint; name: string }[] = [];
  private entries: Entry[] = [];
  private next = 0; // the first one that has not been shown
  private now: bigint;

  /** Throws for a text that is no recording. */
  constructor(text: string) {
    for (const line of text.split("\n")) {
      const first = line.indexOf(" "), second = line.indexOf(" ", first + 1);
      if (first <= 0 || second < 0 || !/^\d{1,19}$/.test(line.slice(first + 1, second))) continue;
      this.entries.push({ topic: line.slice(0, first), at: BigInt(line.slice(first + 1, second)), text: line.slice(second + 1) });
    }
    if (this.entries.length === 0) throw new Error("the recording holds nothing that can be shown");
    this.entries.sort((a, b) => (a.at < b.at ? -1 : a.at > b.at ? 1 : 0));
    this.begins = this.now = this.entries[0]!.at;
    this.ends = this.entries[this.entries.length - 1]!.at;
    this.entries.forEach((entry, i) => {
      if (entry.topic !== "/task/change") return;
      const name = (JSON.parse(entry.text) as TaskChange).state;
      this.states.push({ at: this.shown(name, i), name });
    });
  }

  /** When the status first says it of a state that begins with entry i: some frames after the change. */
  private shown(state: string, i: number): bigint {
    for (let k = i; k < this.entries.length; k++) {
      const { topic, text, at } = this.entries[k]!;
      if (topic === "/task/status" && (JSON.parse(text) as TaskStatus).state === state) return at;
      if (k > i && topic === "/task/change") break;
    }
    return this.entries[i]!.at;
  }

  get at(): bigint { return this.now; }

  /** Shows the recording as it was at that time. */
  seek(to: bigint): void {
    this.now = to < this.begins ? this.begins : to > this.ends ? this.ends : to;
    this.onReset();
    const newest = new Map<string, number>();
    const shown: number[] = [];
    let logs = 0;
    for (this.next = 0; this.next < this.entries.length && this.entries[this.next]!.at <= this.now; this.next++)
      newest.set(this.entries[this.next]!.topic, this.next);
    for (let i = this.next - 1; i >= 0; i--) {
      const { topic } = this.entries[i]!;
      if (MOMENTARY.includes(topic) || (topic === "/log" && ++logs > LOG_LINES)) continue;
      if (HISTORIES.includes(topic) || newest.get(topic) === i) shown.push(i);
    }
    for (const i of shown.reverse()) this.show(i);
  }

  /** Goes on by so much; false: it is at its end. */
  advance(byNs: bigint): boolean {
    this.now = this.now + byNs > this.ends ? this.ends : this.now + byNs;
    const newest = new Map<string, number>();
    const first = this.next;
    for (; this.next < this.entries.length && this.entries[this.next]!.at <= this.now; this.next++)
      newest.set(this.entries[this.next]!.topic, this.next);
    for (let i = first; i < this.next; i++)
      if (HISTORIES.includes(this.entries[i]!.topic) || newest.get(this.entries[i]!.topic) === i) this.show(i);
    return this.now < this.ends;
  }

  /** Beginning of the state after or before now. */
  step(forward: boolean): bigint {
    const slack = 50_000_000n; // what is just reached is not the next one
    const found = forward ? this.states.find((s) => s.at > this.now + 1_000_000n)
      : [...this.states].reverse().find((s) => s.at < this.now - slack);
    return found ? found.at : forward ? this.ends : this.begins;
  }

  private show(i: number): void {
    const entry = this.entries[i]!;
    this.onMessage(entry.topic, entry.text, entry.at);
  }
}
