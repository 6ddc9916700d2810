// The page that shows a run. It is an ordinary client of the channels, as Foxglove or Lichtblick would be.

import { ChoicePanel } from "./choice_panel";
import { LiveClient } from "./live_client";
import type * as M from "./messages";
import { PeoplePanel } from "./people_panel";
import { PipelineStrip, escaped } from "./pipeline_strip";
import { LoadPlots } from "./plots";
import { SceneView } from "./scene_view";

const $ = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;
const LEVELS = ["", "debug", "info", "warning", "error", "fatal"];
const LOG_LINES = 300;

const strip = new PipelineStrip($("strip"));
const choice = new ChoicePanel($("because"), $("candidates"), $("reason"));
const plots = new LoadPlots($("shares"), $("share-plot"), $("tilt-plot"));
const people = new PeoplePanel($("near"), $("felt"), $("near-plot"), $("alarm"));
const scene = new SceneView($<HTMLCanvasElement>("scene"), $("layers"));
const client = new LiveClient();

function theme(name: string): void {
  document.documentElement.dataset.theme = name;
  localStorage.setItem("theme", name);
  scene.background(getComputedStyle(document.documentElement).getPropertyValue("--scene").trim());
  plots.rebuild();
  people.rebuild();
}
theme(localStorage.getItem("theme") ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
const otherTheme = () => theme(document.documentElement.dataset.theme === "dark" ? "light" : "dark");
$("theme").onclick = otherTheme;

function say(level: number, text: string, from: string): void {
  const line = document.createElement("li");
  line.className = LEVELS[level] ?? "";
  line.innerHTML = `<span>${escaped(from)}</span> ${escaped(text)}`;
  const log = $("log");
  log.append(line);
  while (log.children.length > LOG_LINES) log.firstChild?.remove();
  log.scrollTop = log.scrollHeight;
}

/** What will move stands beside the state for a while. */
let announced = 0;
function announce(intent: M.Intent): void {
  const chip = $("intent");
  chip.textContent = intent.motion === null ? intent.says : `next: ${intent.says}`;
  chip.hidden = false;
  clearTimeout(announced);
  announced = window.setTimeout(() => { chip.hidden = true; }, intent.motion === null ? 8000 : 2000);
}

const stop = $<HTMLButtonElement>("stop");
stop.onclick = () => {
  if (client.call("/operator/stop")) stop.textContent = "Stopping";
};

const lower = $<HTMLButtonElement>("lower");
lower.onclick = () => void client.call("/operator/lower");

client.onLink = (word, operates) => {
  const chip = $("link");
  const what = document.title.startsWith("CoLift, recording") ? "recording" : "live";
  chip.textContent = word === "connected" ? (operates ? `${what}, operator` : what) : word;
  chip.className = `chip ${word}`;
  stop.disabled = lower.disabled = !operates;
  if (word === "connected") stop.textContent = "Stop";
};
client.onName = (name) => {
  document.title = name;
  $("name").textContent = name.replace(/^CoLift,? ?/, "");
};
client.onNote = (level, text) => say(level + 2, text, "page");
client.onReset = () => {
  strip.reset();
  choice.reset();
  plots.reset();
  people.reset();
  scene.reset();
  $("log").innerHTML = "";
};

client.on<M.TaskStatus>("/task/status", (s) => {
  $("state").textContent = s.state;
  $("waits").textContent = [s.doing || s.waits_for, s.partner_note].filter((t) => t).join(" · ");
  strip.status(s);
  people.show(s);
  scene.robot.state(s.state);
});
client.on<M.TaskChange>("/task/change", (c) => strip.change(c));
client.on<M.Intent>("/task/intent", (i) => announce(i));
client.on<M.Decision>("/decision", (d) => choice.show(d));
client.on<M.Plan>("/plan", (p) => scene.robot.show(p));
client.on<M.Load>("/load", (l, at) => plots.add(l, at));
client.on<{ transforms: M.Transform[] }>("/tf", (m) => scene.transforms(m.transforms));
client.on<M.JointStates>("/joint_states", (m) => scene.robot.joints(m));
client.on<M.PointCloud>("/cloud", (m) => scene.cloud(m));
client.on<M.SceneUpdate>("/map", (m) => scene.map(m));
client.on<M.SceneUpdate>("/bodies", (m) => scene.bodies(m));
client.on<M.SceneUpdate>("/scene", (m) => scene.update(m));
client.on<M.Log>("/log", (m) => say(m.level, m.message, m.name));
client.on<{ devices: M.Device[] }>("/devices", (m) => {
  $("device-list").innerHTML = m.devices.map((d) =>
    `<li><b>${escaped(d.name)}</b> <span class="health ${escaped(d.state)}">${escaped(d.state)}</span> ` +
    `<span class="count">${d.accepted} taken${d.rejected > 0 ? `, ${d.rejected} refused` : ""}</span> <em>${escaped(d.last_error)}</em></li>`).join("");
});
let stages = "", cycle = "";
const timing = () => { $("timing").textContent = [stages, cycle].filter((t) => t).join(" · "); };
client.on<M.Stages>("/stages", (s) => {
  stages = `look ${(s.look_ms.total ?? 0).toFixed(1)} ms, decide ${s.decision_ms.toFixed(1)} ms, plan ${s.plan_ms.toFixed(1)} ms`;
  timing();
});
client.on<M.CycleTiming>("/arm/timing", (t) => {
  cycle = `arm: ${t.missed} cycles missed` + (t.answer_us_max === null ? "" : `, slowest answer ${t.answer_us_max.toFixed(0)} µs`);
  timing();
});

choice.onSelect = (id) => scene.select(id);
scene.onPick = (id) => choice.select(id);
document.addEventListener("keydown", (event) => {
  if (event.target instanceof HTMLInputElement || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "t") otherTheme();
  if (event.key === "s" && !stop.disabled) stop.click();
});

void scene.robot.load("robot.urdf");
client.connect(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/${location.search}`);
