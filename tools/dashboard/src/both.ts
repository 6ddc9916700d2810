// Two recordings side by side, on one clock: each half is the page itself (main.ts, ?half=) and shows what was at its own time.

import { type Recorded, type ReplayBar, SPEEDS } from "./replay_bar";

const $ = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;
/** A page that was not worked on for longer goes on from where it was (s). */
const LONGEST_STEP_S = 1;

interface Half { name: string; bar: ReplayBar; recorded: Recorded; zero_s: number }

let halves: Half[] = [];
let t_s = 0, playing = false, drawn_ms = 0;
const play = $<HTMLButtonElement>("play"), place = $<HTMLInputElement>("place");
const speed = $<HTMLSelectElement>("speed"), zero = $<HTMLSelectElement>("zero");

/** The page of a half has made its replay: its module runs after it was loaded. */
async function barOf(frame: HTMLIFrameElement): Promise<ReplayBar> {
  for (;;) {
    const bar = (frame.contentWindow as (Window & { halfReplay?: ReplayBar }) | null)?.halfReplay;
    if (bar) return bar;
    await new Promise((later) => setTimeout(later, 20));
  }
}

async function open(name: string): Promise<Half> {
  const bar = await barOf($<HTMLIFrameElement>(name));
  const recorded = await bar.read();
  if (!recorded) throw new Error(`recording ${name.toUpperCase()} cannot be played here`);
  return { name, bar, recorded, zero_s: 0 };
}

/** States that both went through: each can be the common time 0. */
function common(): string[] {
  const [a, b] = halves.map((h) => h.recorded.states.map((s) => s.name));
  return [...new Set(a!.filter((state) => b!.includes(state)))];
}

function align(): void {
  for (const half of halves)
    half.zero_s = half.recorded.states.find((s) => s.name === zero.value)?.at_s ?? 0;
  place.min = String(Math.min(...halves.map((h) => -h.zero_s)));
  place.max = String(Math.max(...halves.map((h) => h.recorded.length_s - h.zero_s)));
  show(0);
}

/** What both were at this time since the common 0. A half that has ended, or not begun, stays there. */
function show(at_s: number): void {
  t_s = Math.min(Math.max(at_s, Number(place.min)), Number(place.max));
  for (const { name, bar, recorded, zero_s } of halves) {
    const own_s = Math.min(Math.max(t_s + zero_s, 0), recorded.length_s);
    bar.showAt(own_s);
    const past = recorded.states.filter((s) => s.at_s <= own_s + 1e-6);
    $(`state-${name}`).textContent = past.length ? `${past[past.length - 1]!.name}, ${own_s.toFixed(1)} s` : "";
  }
  place.value = String(t_s);
  $("time").textContent = `${t_s < 0 ? "−" : ""}${Math.abs(t_s).toFixed(1)} s`;
}

function turn(on: boolean): void {
  playing = on;
  play.textContent = on ? "Pause" : "Play";
  drawn_ms = performance.now();
  if (on && t_s >= Number(place.max)) show(Number(place.min));
  if (on) requestAnimationFrame(step);
}

function step(now_ms: number): void {
  if (!playing) return;
  const passed_s = Math.min(LONGEST_STEP_S, Math.max(0, now_ms - drawn_ms) / 1000);
  drawn_ms = now_ms;
  show(t_s + passed_s * Number(speed.value));
  if (t_s >= Number(place.max)) turn(false);
  else requestAnimationFrame(step);
}

for (const s of SPEEDS) speed.add(new Option(`${s} ×`, String(s), s === 1, s === 1));
play.onclick = () => turn(!playing);
place.oninput = () => {
  turn(false);
  show(Number(place.value));
};
zero.onchange = align;
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || event.target instanceof HTMLButtonElement || event.target instanceof HTMLSelectElement) return;
  event.preventDefault();
  turn(!playing);
});

Promise.all([open("a"), open("b")]).then((opened) => {
  halves = opened;
  for (const state of common()) zero.add(new Option(`begin of ${state}`, state, state === "lift", state === "lift"));
  zero.add(new Option("start", "", zero.length === 0, zero.length === 0));
  align();
}).catch((error: Error) => {
  $("problem").textContent = error.message;
  $("problem").hidden = false;
});
