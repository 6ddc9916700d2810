// The page with messages of the test's own choice: a server of Foxglove's protocol that says what the test tells it to.
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { WebSocketServer } from "ws";

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css" };
const TOPICS = ["/tf", "/joint_states", "/camera/calibration", "/camera/preview", "/scene", "/log", "/task/status", "/task/intent", "/task/change",
  "/decision", "/plan", "/devices", "/load", "/hand/tactile", "/bodies"];

/** Serves the page in `folder`. What is run is chosen with begin(). */
export async function playedRun(folder) {
  const run = { calls: [], stops: 0 };
  let shown = { name: "CoLift", documents: {}, operates: false }, session = 0;
  const server = createServer((request, response) => {
    const path = new URL(request.url, "http://page").pathname;
    if (request.method === "POST" && path === "/operator/stop") {
      ++run.stops;
      return response.end('{"done":true}');
    }
    if (path in shown.documents) return response.end(shown.documents[path]);
    const file = path === "/" ? "index.html" : normalize(path).replace(/^(\.\.[/\\])+/, "");
    try {
      const body = readFileSync(join(folder, file));
      response.setHeader("Content-Type", TYPES[extname(file)] ?? "text/plain");
      response.end(body);
    } catch {
      response.statusCode = 404;
      response.end();
    }
  });
  const newest = new Map();
  let client = null, subscribed = new Map(), away = false, onSubscribed = () => {};
  const send = (id, text, atNs) => {
    const payload = Buffer.from(text), head = Buffer.alloc(13);
    head.writeUInt8(1, 0);
    head.writeUInt32LE(id, 1);
    head.writeBigUInt64LE(BigInt(atNs), 5);
    client.send(Buffer.concat([head, payload]));
  };
  const welcome = () => {
    subscribed = new Map();
    client.send(JSON.stringify({ op: "serverInfo", name: shown.name, capabilities: [], sessionId: String(session) }));
    client.send(JSON.stringify({ op: "advertise", channels: TOPICS.map((topic, id) => ({ id, topic, encoding: "json" })) }));
    if (shown.operates) client.send(JSON.stringify({ op: "advertiseServices", services: [
      { id: 1, name: "/operator/stop" }, { id: 3, name: "/operator/continue" }] }));
  };
  new WebSocketServer({ server, handleProtocols: () => "foxglove.sdk.v1" }).on("connection", (socket) => {
    client?.terminate();
    if (away) return socket.terminate();
    client = socket;
    welcome();
    socket.on("close", () => { if (client === socket) client = null; });
    socket.on("message", (data, binary) => {
      if (binary) return run.calls.push(data.readUInt32LE(1));
      const message = JSON.parse(data);
      if (message.op !== "subscribe") return;
      for (const { id, channelId } of message.subscriptions) {
        subscribed.set(TOPICS[channelId], id);
        const kept = newest.get(TOPICS[channelId]);
        if (kept) send(id, kept.text, kept.atNs);
      }
      onSubscribed();
    });
  });
  await new Promise((listening) => server.listen(0, "127.0.0.1", listening));
  run.url = `http://127.0.0.1:${server.address().port}/`;
  /** To whoever is connected, and to who comes later. */
  run.say = (topic, message, t_s = 0) => {
    const kept = { text: JSON.stringify(message), atNs: Math.round(1e9 * t_s) };
    newest.set(topic, kept);
    if (client && subscribed.has(topic)) send(subscribed.get(topic), kept.text, kept.atNs);
  };
  /** Another run: `documents` are further ones by path, `operates` offers the operator's services. Waits until the page has it. */
  run.begin = async ({ name = "CoLift", documents = {}, operates = false } = {}) => {
    shown = { name, documents, operates };
    ++session;
    newest.clear();
    run.calls = [];
    run.stops = 0;
    const taken = new Promise((done) => { onSubscribed = done; });
    if (client) welcome();
    await taken;
  };
  /** The link is lost (true), and nobody gets one until it is there again. */
  run.away = (is) => {
    away = is;
    if (is) client?.terminate();
  };
  run.end = () => {
    client?.terminate();
    server.close();
  };
  return run;
}

const UPRIGHT = { x: 0, y: 0, z: 0, w: 1 };
const entity = (id, more) => ({ id, metadata: [], arrows: [], cubes: [], spheres: [], cylinders: [], lines: [], ...more });
export const BOX = { center: { x: 0.8, y: 0, z: 0.7 }, size: { x: 0.6, y: 0.3, z: 0.05 } };

/** A scene with an object, its partner, and one candidate for each verdict. */
export function scene(verdicts) {
  return {
    deletions: [{ type: 1, id: "" }],
    entities: [
      entity("ground", { cubes: [{ pose: { position: { x: 0.8, y: 0, z: 0 }, orientation: UPRIGHT }, size: { x: 3, y: 3, z: 0.001 },
        color: { r: 0.6, g: 0.6, b: 0.6, a: 0.25 } }] }),
      entity("target", { cubes: [{ pose: { position: BOX.center, orientation: UPRIGHT }, size: BOX.size, color: { r: 0.9, g: 0.62, b: 0, a: 0.25 } }] }),
      entity("partner", { spheres: [{ pose: { position: { x: 1.1, y: 0, z: 0.7 }, orientation: UPRIGHT }, size: { x: 0.05, y: 0.05, z: 0.05 },
        color: { r: 0.8, g: 0.2, b: 0.6, a: 0.6 } }] }),
      ...verdicts.map((verdict, i) => entity(`candidate ${i}`, {
        metadata: [{ key: "verdict", value: verdict }],
        arrows: [{ pose: { position: { x: 0.4, y: 0.1 * i - 0.35, z: 0.7 }, orientation: UPRIGHT }, shaft_length: 0.06, shaft_diameter: 0.006,
          head_length: 0.03, head_diameter: 0.02, color: { r: 0.3, g: 0.7, b: 0.9, a: 1 } }],
      })),
    ],
  };
}

export function decision(verdicts) {
  return { t: 3, chosen: 0, share: 0.45, cost: 12, because: "grasp 0 leaves the partner the wanted share", candidates: verdicts.map((verdict, id) => ({
    id, kind: "side", position: [0.45, 0, 0.7], approach: [1, 0, 0], closing: [0, 0, 1], width: 0.05, verdict,
    because: verdict === "chosen" ? "" : "the hand meets the table with its second finger", stability: 0.7, share: 0.45, cost: 12 + id })) };
}

export function status(state, more = {}) {
  return { t: 4, state, in_state_s: 1.2, because: "a test says so", waits_for: "the object to reach its height", doing: "", done: 0.5, partner: [1.1, 0, 0.7],
    partner_note: "", separation: { on: true, speed_scale: 0.4, waits: false, because: "a person is 0.62 m from the arm", distance_m: 0.62, hold_distance_m: 0.3,
      slow_distance_m: 0.8, bodies: [] }, force: { on: true, felt: [0, 0, -0.01], sideways_limit_n: 30, up_limit_n: 40, down_limit_n: 40, exceeded: false }, ...more };
}

export function load(height_m, more = {}) {
  return { load_n: 21.4, share: 0.46, share_predicted: 0.45, height_m, tilt_deg: 0.3, slip_m: 0.001, leads: "robot", ...more };
}

export function tactile(pressure) {
  const cells = (count) => Array.from({ length: count }, (_, i) => (i % 5 === 0 ? pressure : 0));
  return { arrays: ["F1", "F2", "F3"].map((name) => ({ name, at: 1, force_n: 0.2 * pressure, cells: cells(24) }))
    .concat([{ name: "palm", at: 1, force_n: null, cells: cells(24) }]), palm_touches: pressure > 0 };
}
