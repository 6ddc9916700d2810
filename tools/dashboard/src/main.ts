// The page that shows a run. It is an ordinary client of the channels, as Foxglove or Lichtblick would be.

import * as THREE from "three";
import { CameraPanel } from "./camera_panel";
import { ChoicePanel } from "./choice_panel";
import { HandPanel } from "./hand_panel";
import { LiveClient } from "./live_client";
import type * as M from "./messages";
import { OperatorStop } from "./operator_stop";
import { Pace } from "./pace";
import { PeoplePanel } from "./people_panel";
import { PipelineStrip } from "./pipeline_strip";
import { LoadPlots } from "./plots";
import { ReplayBar } from "./replay_bar";
import { SceneView } from "./scene_view";
import { escaped, heightWords, leaderWords } from "./words";

const $ = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;
const LEVELS = ["", "debug", "info", "warning", "error", "fatal"];
const LOG_LINES = 300;
const OVER = ["done", "aborted", "refused", "stopped"];

const strip = new PipelineStrip($("strip"));
const choice = new ChoicePanel($("because"), $("candidates"), $("reason"));
const plots = new LoadPlots($("shares"), $("share-plot"), $("tilt-plot"));
const people = new PeoplePanel($("near"), $("felt"), $("near-plot"), $("alarm"));
const scene = new SceneView($<HTMLCanvasElement>("scene"), $("layers"));
const hand = new HandPanel($("touch"), $("tactile"));
const moved = (p: THREE.Vector3 | null) => p && p.clone().applyMatrix4(scene.motion.matrix);
const camera = new CameraPanel($("seen"), $<HTMLCanvasElement>("camera-picture"), () => ({
  box: scene.restBox && scene.motion.matrix.clone().multiply(scene.restBox),
  partner, grasp: moved(grasp), path: scene.palm.rest,
}));
const client = new LiveClient("robot.urdf");
const pace = new Pace();
for (const view of [scene, plots, people, camera]) pace.add(view);

function theme(name: string): void {
  document.documentElement.dataset.theme = name;
  localStorage.setItem("theme", name);
  scene.background(getComputedStyle(document.documentElement).getPropertyValue("--scene").trim());
  plots.rebuild();
  people.rebuild();
  pace.wake();
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

// it can be pressed without a link too: the address holds what the server asks for
const stop = $<HTMLButtonElement>("stop");
const stopping = new OperatorStop(`operator/stop${location.search}`);
stopping.onWord = (word) => { stop.textContent = word; };
stopping.onCall = () => void client.call("/operator/stop");
stopping.onNote = (level, text) => say(LEVELS.indexOf(level), text, "page");
stop.onclick = () => void stopping.press();

const lower = $<HTMLButtonElement>("lower");
lower.onclick = () => void client.call("/operator/lower");

// pressed at any other time it would have no effect
const proceed = $<HTMLButtonElement>("continue");
let operating = false, toConfirm = false;
const showProceed = () => { proceed.disabled = !operating || !toConfirm; };
proceed.onclick = () => void client.call("/operator/continue");

const isRecording = () => document.title.startsWith("CoLift, recording");
let mayOperate = new URLSearchParams(location.search).has("token"), wasLinked = false;
/** Of a run the buttons say who may press them; a recording has nothing to stop. */
const showActions = () => { $("actions").hidden = isRecording() && !mayOperate; };
client.onLink = (word, operates) => {
  const chip = $("link");
  const what = isRecording() ? "recording" : "live";
  chip.textContent = word === "connected" ? (operates ? `${what}, operator` : what) : word;
  chip.className = `chip ${word}`;
  mayOperate ||= operates;
  stop.disabled = word === "connected" ? !operates : !mayOperate;
  lower.disabled = !operates;
  operating = operates;
  showProceed();
  showActions();
  wasLinked ||= word === "connected";
  $("lost").hidden = word === "connected" || !wasLinked;
  $("lost-more").textContent = mayOperate ? "Stop is sent all the same." : "";
  document.body.classList.toggle("old", !$("lost").hidden);
};
client.onName = (name) => {
  document.title = name;
  $("name").textContent = name.replace(/^CoLift,? ?/, "");
  bar.show(isRecording());
  showActions();
};
client.onNote = (level, text) => say(level + 2, text, "page");
client.onDamage = (topic) => say(3, `a message of ${topic} is damaged`, "page");
client.onMail = () => pace.wake();
scene.onTouch = () => pace.wake();
const reset = () => {
  strip.reset();
  choice.reset();
  plots.reset();
  people.reset();
  scene.reset();
  hand.reset();
  camera.reset();
  partner = grasp = null;
  toConfirm = false;
  showProceed();
  leads = "";
  $("leads").hidden = $("intent").hidden = true;
  $("log").innerHTML = "";
  for (const id of ["waits", "note"]) $(id).textContent = "";
  $("state").textContent = "no state yet";
};
client.onReset = () => {
  reset();
  stopping.reset();
  bar.forget();
};

// one of two halves (both.ts): a recording by itself, without a server and without controls
const half = /^[a-z]+\.txt$/.exec(new URLSearchParams(location.search).get("half") ?? "")?.[0];
const bar = new ReplayBar($("replay"), half ?? "recording.txt", {
  show: (topic, text, at) => {
    try {
      client.hand(topic, text, at);
    } catch {
      client.onDamage(topic);
    }
    pace.wake();
  },
  reset,
  failed: (why) => say(3, why, "page"),
});
bar.onJump = () => {
  scene.motion.jump();
  scene.touch();
};
bar.onPlay = () => pace.wake();
pace.work = (max_ms) => {
  const more = client.work(max_ms);
  return bar.work(performance.now()) || more;
};
bar.onOwn = (own) => {
  client.muted = own;
  if (!own) {
    reset();
    client.again();
  }
};
client.onMessage = (at) => bar.follows(at);

let leads = "";
let partner: THREE.Vector3 | null = null, grasp: THREE.Vector3 | null = null;
const vector = (p: number[] | null | undefined) => (p && p.length === 3 ? new THREE.Vector3(p[0], p[1], p[2]) : null);

client.on<M.TaskStatus>("/task/status", (s) => {
  $("state").textContent = s.state;
  $("waits").textContent = s.doing || s.waits_for;
  $("note").textContent = OVER.includes(s.state) ? "" : s.partner_note; // nobody looks for him any more
  partner = vector(s.partner);
  toConfirm = s.separation?.may_confirm === true;
  showProceed();
  strip.status(s);
  people.show(s);
  const was = scene.robot.ghost.visible;
  if (scene.robot.state(s.state) && scene.palm.arrived()) scene.touch();
  if (was !== scene.robot.ghost.visible) scene.touch();
});
client.on<M.TaskChange>("/task/change", (c) => strip.change(c));
client.on<M.Intent>("/task/intent", (i) => announce(i));
client.on<M.Decision>("/decision", (d) => {
  choice.show(d);
  grasp = vector(d.candidates.find((c) => c.id === d.chosen)?.position);
});
client.on<M.Plan>("/plan", (p) => {
  scene.robot.show(p);
  scene.palm.plan(p.palm);
  scene.touch();
});
client.on<M.Load>("/load", (l, at) => {
  plots.add(l, at);
  scene.motion.height(l.height_m, Number(at) / 1e9);
  leads = leaderWords(l.leads);
  $("leads").textContent = leads;
  $("leads").hidden = leads === "";
  scene.say(l.height_m === null ? "" : [heightWords(l.height_m), leads].filter((t) => t).join(", "));
});
client.on<{ transforms: M.Transform[] }>("/tf/tracked", (m, at) => scene.transforms(m.transforms, Number(at) / 1e9));
client.on<{ transforms: M.Transform[] }>("/tf", (m, at) => {
  scene.transforms(m.transforms, Number(at) / 1e9);
  const lens = m.transforms.find((t) => t.child_frame_id === "camera");
  if (lens) camera.pose(lens);
  camera.touch();
});
client.on<M.Calibration>("/camera/calibration", (m) => camera.model(m));
client.on<M.RawImage>("/camera/preview", (m) => camera.show(m));
client.on<M.Tactile>("/hand/tactile", (m) => hand.show(m));
client.on<M.JointStates>("/joint_states", (m) => { if (scene.robot.joints(m)) scene.touch(); });
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
  const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
  if (typing || event.ctrlKey || event.metaKey || event.altKey) return;
  if (!(event.key === " " && event.target instanceof HTMLButtonElement) && bar.key(event.key)) return event.preventDefault();
  if (event.key === "t") otherTheme();
  if (event.key === "s" && !stop.disabled) stop.click();
});

if (matchMedia("(max-width: 44rem)").matches) $<HTMLDetailsElement>("shown").open = false;
void scene.robot.load("robot.urdf").then(() => scene.touch());
if (half) {
  document.documentElement.dataset.half = half;
  Object.assign(window, { halfReplay: bar });
} else client.connect(`${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/${location.search}`);
