// Plays a recording: pause, place, speed, from state to state. Until one of them is used the page follows what the server sends.

import { Recording } from "./recording";

export const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];
/** A page that was not worked on for longer goes on from where it was (s). */
const LONGEST_STEP_S = 2;

/** What a recording holds: its length, and its states with their beginnings. */
export interface Recorded { length_s: number; states: { name: string; at_s: number }[] }

export class ReplayBar {
  /** The page now plays by itself (true), or follows the server again. */
  onOwn: (own: boolean) => void = () => {};
  /** A place was chosen: motions are not drawn from where they were. */
  onJump: () => void = () => {};
  /** From now on work() is asked for. */
  onPlay: () => void = () => {};
  private recording: Recording | null = null;
  private loading = false;
  private playing = false;
  private drawn_ms = 0;
  private followed = 0n; // what the server has sent last
  private slider: HTMLInputElement;
  private speed: HTMLSelectElement;

  constructor(private bar: HTMLElement, private url: string,
    private wire: { show: Recording["onMessage"]; reset: () => void; failed: (why: string) => void }) {
    bar.innerHTML =
      `<button data-do="begin" title="To the beginning (Home)" aria-label="To the beginning">|◀◀</button>` +
      `<button data-do="back" title="State before (,)" aria-label="State before">◀︎|</button>` +
      `<button data-do="play" title="Play or pause (space)">Pause</button>` +
      `<button data-do="forward" title="Next state (.)" aria-label="Next state">|▶︎</button>` +
      `<input type="range" min="0" max="1000" value="0" step="1" aria-label="Place in the recording" />` +
      `<output></output><label>speed <select></select></label>` +
      `<button data-do="live" title="What the replay computes, as it does" hidden>Follow</button><ol></ol>`;
    this.slider = bar.querySelector("input")!;
    this.speed = bar.querySelector("select")!;
    for (const s of SPEEDS) this.speed.add(new Option(`${s} ×`, String(s), s === 1, s === 1));
    bar.addEventListener("click", (event) => {
      const button = (event.target as HTMLElement).closest<HTMLElement>("button");
      if (button?.dataset.do) void this.act(button.dataset.do);
      if (button?.dataset.at) void this.to(BigInt(button.dataset.at));
    });
    this.slider.addEventListener("input", () => void this.act("seek"));
    this.speed.addEventListener("change", () => { if (!this.recording) void this.act("play"); });
  }

  /** Plays on to this moment. True: it goes on. */
  work(now_ms: number): boolean {
    const passed_s = Math.min(LONGEST_STEP_S, Math.max(0, now_ms - this.drawn_ms) / 1000);
    this.drawn_ms = now_ms;
    if (!this.playing || !this.recording) return false;
    this.playing = this.recording.advance(BigInt(Math.round(passed_s * 1e9 * Number(this.speed.value))));
    this.say();
    return this.playing;
  }

  show(on: boolean): void { this.bar.hidden = !on; }

  /** For a page that plays two side by side: how long it is, and when its states begin (s since its beginning). */
  async read(): Promise<Recorded | null> {
    const r = await this.open();
    const since = (at: bigint) => Number(at - r!.begins) / 1e9;
    return r && { length_s: since(r.ends), states: r.states.map(({ name, at }) => ({ name, at_s: since(at) })) };
  }

  /** Shows what was at that time (s since its beginning): plays on to it where it is little later than now. */
  showAt(t_s: number): void {
    const r = this.recording;
    if (!r) return;
    const to = r.begins + BigInt(Math.round(1e9 * t_s)), later_s = Number(to - r.at) / 1e9;
    if (later_s >= 0 && later_s <= LONGEST_STEP_S) r.advance(to - r.at);
    else {
      r.seek(to);
      this.onJump();
    }
    this.say();
  }

  /** Another recording, or another run: what was read of the last one is over. */
  forget(): void { if (this.recording) this.follow(); }

  /** Of what the server sends, while the page follows it. */
  follows(atNs: bigint): void {
    this.followed = atNs;
  }

  /** Space, comma, full stop, Home and End; true: it was one of them. */
  key(key: string): boolean {
    const what = ({ " ": "play", ",": "back", ".": "forward", Home: "begin", End: "end" } as Record<string, string>)[key];
    if (this.bar.hidden || !what) return false;
    void this.act(what);
    return true;
  }

  async act(what: string): Promise<void> {
    if (what === "live") return this.follow();
    const first = this.recording === null;
    const recording = await this.open();
    if (!recording) return;
    const length = recording.ends - recording.begins;
    if (what === "play") {
      this.playing = first ? false : !this.playing;
      if (this.playing && recording.at >= recording.ends) recording.seek(recording.begins);
      this.drawn_ms = performance.now();
      this.onPlay();
    }
    if (what === "begin") await this.to(recording.begins);
    if (what === "end") await this.to(recording.ends);
    if (what === "back" || what === "forward") await this.to(recording.step(what === "forward"));
    if (what === "seek") await this.to(recording.begins + length * BigInt(this.slider.value) / 1000n);
    this.say();
  }

  private async to(at: bigint): Promise<void> {
    const recording = await this.open();
    if (!recording) return;
    this.playing = false;
    recording.seek(at);
    this.onJump();
    this.say();
  }

  /** The file, once; the page then plays it from where the server has come. */
  private async open(): Promise<Recording | null> {
    if (this.recording || this.loading) return this.recording;
    this.loading = true;
    try {
      const answer = await fetch(this.url);
      if (!answer.ok) throw new Error(`the server answers ${answer.status}`);
      const recording = new Recording(await answer.text());
      recording.onMessage = this.wire.show;
      recording.onReset = this.wire.reset;
      this.recording = recording;
      this.onOwn(true);
      recording.seek(this.followed);
      this.onJump();
      this.bar.querySelector<HTMLElement>("[data-do=live]")!.hidden = false;
      const states = this.bar.querySelector("ol")!;
      for (const state of recording.states) {
        const item = document.createElement("li"), button = document.createElement("button");
        button.dataset.at = String(state.at);
        button.textContent = state.name;
        item.append(button);
        states.append(item);
      }
    } catch (error) {
      this.wire.failed(`the recording cannot be played here: ${(error as Error).message}`);
    } finally {
      this.loading = false;
    }
    return this.recording;
  }

  private follow(): void {
    this.recording = null;
    this.playing = false;
    this.bar.querySelector("ol")!.innerHTML = "";
    this.bar.querySelector<HTMLElement>("[data-do=live]")!.hidden = true;
    this.bar.querySelector("output")!.textContent = "";
    this.bar.querySelector<HTMLElement>("[data-do=play]")!.textContent = "Pause";
    this.onOwn(false);
  }

  private say(): void {
    const r = this.recording;
    if (!r) return;
    const length = Number(r.ends - r.begins) || 1;
    this.slider.value = String(Math.round(1000 * Number(r.at - r.begins) / length));
    const words = `${time(Number(r.at - r.begins) / 1e9)} of ${time(length / 1e9)}`;
    this.slider.setAttribute("aria-valuetext", words);
    this.bar.querySelector("output")!.textContent = words;
    this.bar.querySelector<HTMLElement>("[data-do=play]")!.textContent = this.playing ? "Pause" : "Play";
    for (const button of this.bar.querySelectorAll<HTMLElement>("ol button")) button.removeAttribute("aria-current");
    const past = [...this.bar.querySelectorAll<HTMLElement>("ol button")].filter((b) => BigInt(b.dataset.at!) <= r.at);
    past[past.length - 1]?.setAttribute("aria-current", "true");
  }
}

function time(s: number): string { return `${s.toFixed(1)} s`; }
