// Foxglove's own client reads our channels, in both sub-protocols.
import assert from "node:assert/strict";
import { get, request } from "node:http";
import { connect } from "node:net";
import { hostname } from "node:os";
import { after, before, test } from "node:test";
import protocol from "@foxglove/ws-protocol";
import schemas from "@foxglove/schemas/jsonschema.js";
import WebSocket from "ws";
import { scenario, startLift, startView, until } from "./running_lift.mjs";

const { FoxgloveClient } = protocol;
let lift;
// with things about the table: a table alone leaves nothing to go around
before(async () => { lift = await startLift("--speed", "6", "--scenario", scenario("cluttered_table")); });
after(async () => { await lift.end(); });

/** std_msgs/msg/String in CDR: encapsulation, length with the zero at its end, text. */
function textOf(data) {
  assert.equal(data.getUint32(0), 0x00010000);
  const length = data.getUint32(4, true);
  assert.equal(data.byteLength, 8 + length);
  return new TextDecoder().decode(new Uint8Array(data.buffer, data.byteOffset + 8, length - 1));
}

function listen(protocol, of = lift) {
  const socket = new WebSocket(of.url.replace("http", "ws"), [protocol]);
  const client = new FoxgloveClient({ ws: socket });
  const seen = { info: null, channels: new Map(), messages: new Map(), status: [], services: [], failures: [], open: true, client, socket };
  const topics = new Map();
  client.on("serverInfo", (info) => { seen.info = info; });
  client.on("time", ({ timestamp }) => { seen.time = timestamp; });
  client.on("status", (status) => { seen.status.push(status); });
  client.on("close", () => { seen.open = false; });
  client.on("advertiseServices", (services) => { seen.services.push(...services); });
  client.on("serviceCallFailure", (failure) => { seen.failures.push(failure); });
  client.on("advertise", (channels) => {
    for (const channel of channels) {
      seen.channels.set(channel.topic, channel);
      topics.set(client.subscribe(channel.id), channel.topic);
    }
  });
  client.on("message", ({ subscriptionId, data }) => {
    const topic = topics.get(subscriptionId);
    const value = seen.channels.get(topic).encoding === "json" ? JSON.parse(new TextDecoder().decode(data)) : textOf(data);
    seen.messages.set(topic, [...(seen.messages.get(topic) ?? []), value]);
  });
  return seen;
}

for (const protocol of ["foxglove.websocket.v1", "foxglove.sdk.v1"])
  test(`a client that speaks ${protocol} gets every channel of a lift`, async () => {
    const seen = listen(protocol);
    await until(() => seen.messages.has("/decision") && seen.messages.has("/tf") && seen.messages.has("/scene"), "a decision");
    assert.equal(seen.socket.protocol, protocol);
    assert.deepEqual(seen.info.capabilities, ["time"]);
    assert.equal(seen.services.length, 0);
    for (const topic of ["/task/status", "/task/change", "/joint_states", "/cloud", "/map", "/devices", "/camera/calibration"])
      await until(() => seen.messages.has(topic), topic);
    assert.ok(seen.time > 0n && seen.time < 600n * 10n ** 9n, "the robot's clock, not the wall's");
    // the robot's model, which was said once, long before
    await until(() => seen.messages.has("/robot_description"), "the robot's model");
    const { schemaName, schemaEncoding, schema } = seen.channels.get("/robot_description");
    assert.deepEqual([schemaName, schemaEncoding, schema], ["std_msgs/msg/String", "ros2msg", "string data\n"]);
    const links = [...seen.messages.get("/robot_description").at(-1).matchAll(/<link name="(\w+)"/g)].map((found) => found[1]);
    const frames = new Set(seen.messages.get("/tf").at(-1).transforms.map((t) => t.child_frame_id));
    assert.ok(links.length > 15 && links.every((link) => link === "world" || frames.has(link)), "every link has its place in /tf");
    const map = seen.messages.get("/map").at(-1);
    assert.deepEqual(map.entities.map((e) => e.id), ["obstacles", "target", "hidden"]);
    assert.ok(map.entities[0].cubes.length > 0 && map.entities[1].cubes.length > 0);
    // the scene with the chosen grasp is published after the decision
    await until(() => seen.messages.get("/scene").at(-1).entities.some((e) => e.id === "gripper" && e.arrows.length === 3), "the grasp");
    const decision = seen.messages.get("/decision").at(-1);
    assert.ok(decision.candidates.length > 10);
    assert.ok(decision.candidates.every((c) => c.because !== "" || ["ok", "chosen"].includes(c.verdict)));
    seen.client.close();
  });

test("object and partner are frames that move with them, each pose stamped by its picture", async () => {
  const other = await startLift("--speed", "2");
  const seen = listen("foxglove.sdk.v1", other);
  const places = () => (seen.messages.get("/tf/tracked") ?? []).flatMap((m) => m.transforms);
  await until(() => ["object", "partner"].every((name) => places().some((t) => t.child_frame_id === name)), "object and partner");
  const of = (name) => places().filter((t) => t.child_frame_id === name).map((t) => BigInt(t.timestamp.sec) * 10n ** 9n + BigInt(t.timestamp.nsec));
  for (const name of ["object", "partner"]) of(name).forEach((at, i, all) => assert.ok(i === 0 || at > all[i - 1], `${name}: later and later`));
  seen.client.close();
  await other.end();
});

test("channels named as Foxglove's have the properties of Foxglove's schemas", async () => {
  const seen = listen("foxglove.sdk.v1");
  await until(() => seen.channels.size > 0, "channels");
  let compared = 0;
  for (const channel of seen.channels.values()) {
    if (!channel.schemaName.startsWith("foxglove.")) continue;
    const theirs = schemas[channel.schemaName.slice("foxglove.".length)];
    if (!theirs) continue;
    const known = Object.keys(theirs.properties);
    for (const ours of Object.keys(JSON.parse(channel.schema).properties)) assert.ok(known.includes(ours), `${channel.schemaName}.${ours}`);
    ++compared;
  }
  assert.ok(compared >= 6);
  seen.client.close();
});

test("nobody stops the run without the operator's token", async () => {
  const seen = listen("foxglove.websocket.v1");
  await until(() => seen.info, "a greeting");
  seen.client.sendServiceCallRequest({ serviceId: 1, callId: 5, encoding: "json", data: new DataView(new ArrayBuffer(0)) });
  await until(() => seen.failures.length > 0, "a refusal");
  assert.match(seen.failures[0].message, /operator/);
  seen.client.close();
});

test("the operator's stop is a request of its own: it needs the token and our own page, and no channel that works", async () => {
  const view = await startView("run", "--view", "0", "--quiet", "--speed", "1", "--seed", "1", "--allow-operator");
  const asked = (method, path, headers = {}) => new Promise((done, failed) => {
    request(new URL(path, view.url), { method, headers }, (response) => {
      response.resume();
      done(response.statusCode);
    }).on("error", failed).end();
  });
  const right = `/operator/stop${new URL(view.url).search}`;
  const behind = new WebSocket(view.url.replace("http", "ws"), ["foxglove.sdk.v1"]);
  try {
    // one that reads nothing, and asks for everything
    await new Promise((open) => behind.on("open", open));
    behind.send(JSON.stringify({ op: "subscribe", subscriptions: [...Array(22).keys()].map((id) => ({ id, channelId: id })) }));
    behind.pause();
    assert.equal(await asked("POST", "/operator/stop"), 403);
    assert.equal(await asked("POST", `/operator/stop?token=${"0".repeat(32)}`), 403);
    assert.equal(await asked("POST", right, { Origin: "https://elsewhere.example" }), 403);
    assert.equal(await asked("GET", right), 404);
    assert.equal(await asked("POST", `/robot.urdf${new URL(view.url).search}`), 405);
    assert.ok(!/keeps the last state/.test(view.errors), "it goes on");
    assert.equal(await asked("POST", right, { Origin: new URL(view.url).origin }), 200);
    await until(() => /keeps the last state/.test(view.errors), "the end of the run");
  } finally {
    behind.terminate();
    view.child.kill("SIGKILL");
  }
});

test("an operator who has read nothing for a whole lift is still connected, and gets how it stands, not all that has been", async () => {
  const view = await startView("run", "--view", "0", "--quiet", "--speed", "6", "--seed", "1", "--allow-operator");
  const behind = new WebSocket(view.url.replace("http", "ws"), ["foxglove.sdk.v1"]);
  try {
    let closed = false, bytes = 0, said = "", channels = [];
    behind.on("close", () => { closed = true; });
    // from the beginning: the channels may come together with the answer that opens it
    behind.on("message", (data, binary) => {
      if (!binary && JSON.parse(data).op === "advertise") channels = JSON.parse(data).channels;
    });
    await until(() => channels.length > 0, "the channels");
    behind.send(JSON.stringify({ op: "subscribe", subscriptions: channels.map(({ id }) => ({ id, channelId: id })) }));
    behind.pause();
    await until(() => /keeps the last state/.test(view.errors), "the end of the lift", 120000);
    const status = channels.find((c) => c.topic === "/task/status").id;
    behind.on("message", (data, binary) => {
      bytes += data.length;
      if (binary && data.readUInt8(0) === 1 && data.readUInt32LE(1) === status) said = JSON.parse(data.subarray(13)).state;
    });
    behind.resume();
    await until(() => ["done", "aborted", "stopped", "refused"].includes(said), "how it stands");
    assert.ok(bytes < 2e6, `${bytes} bytes of what has been`);
    assert.ok(!closed);
  } finally {
    behind.terminate();
    view.child.kill("SIGKILL");
  }
});

test("garbage is answered with a status, a flood ends its own connection, and the others go on", async () => {
  const watcher = listen("foxglove.sdk.v1");
  const rude = listen("foxglove.sdk.v1");
  await until(() => rude.info && watcher.info, "greetings");
  for (const garbage of ["", "{", "[]", '{"op":"subscribe","subscriptions":[{"id":-1}]}', Buffer.from([0]), Buffer.alloc(5000, 255)])
    rude.socket.send(garbage);
  await until(() => rude.status.length >= 6, "complaints");
  assert.ok(rude.open);
  for (let i = 0; i < 2000 && rude.socket.readyState === WebSocket.OPEN; ++i) rude.socket.send("{}");
  await until(() => !rude.open, "the end of the flood's connection");
  const huge = listen("foxglove.sdk.v1");
  await until(() => huge.info, "a greeting");
  huge.socket.send(Buffer.alloc(1 << 20));
  await until(() => !huge.open, "the end of an endless message's connection");
  const before = watcher.messages.get("/task/status")?.length ?? 0;
  assert.ok(watcher.open);
  assert.ok(before > 0);
  watcher.client.close();
});

test("a viewer that never reads changes nothing about a run, bit for bit", async () => {
  const dry = ["--seed", "1", "--dry-run", "--json"];
  const plain = await startView("run", "--view", "0", "--speed", "0", ...dry);
  const watched = await startView("run", "--view", "0", "--speed", "0", ...dry);
  const socket = new WebSocket(watched.url.replace("http", "ws"), ["foxglove.sdk.v1"]);
  await new Promise((open) => socket.on("open", open));
  socket.send(JSON.stringify({ op: "subscribe", subscriptions: [...Array(22).keys()].map((id) => ({ id, channelId: id })) }));
  socket.pause();
  const documents = [];
  for (const run of [plain, watched]) {
    await until(() => run.output.endsWith("\n"), "the run's document");
    const document = JSON.parse(run.output);
    document.timing = null; // how long the machine took
    documents.push(JSON.stringify(document));
    assert.equal(await run.end(), 0);
  }
  socket.terminate();
  assert.equal(documents[0], documents[1]);
});

test("connections that say nothing, and watchers in every place, do not lock the operator out", async () => {
  const view = await startView("run", "--view", "0", "--quiet", "--speed", "1", "--seed", "1", "--allow-operator");
  const address = new URL(view.url), silent = [], watchers = [];
  try {
    for (let i = 0; i < 40; ++i) silent.push(connect(Number(address.port), address.hostname).on("error", () => {}));
    await Promise.all(silent.map((socket) => socket.readyState === "open" || new Promise((open) => socket.on("connect", open).on("close", open))));
    const refusals = [];
    for (let i = 0; i < 40; ++i) {
      const socket = new WebSocket(`ws://${address.host}/`, ["foxglove.sdk.v1"]);
      watchers.push(socket);
      await new Promise((done) => socket.on("open", done).on("error", done)
        .on("unexpected-response", (_, response) => { refusals.push(response.statusCode); done(); }));
    }
    assert.deepEqual(refusals, Array(8).fill(503)); // 32 places for who watches
    for (let i = 0; i < 40; ++i) silent.push(connect(Number(address.port), address.hostname).on("error", () => {}));
    const seen = { services: [] };
    const operator = new WebSocket(view.url.replace("http", "ws"), ["foxglove.sdk.v1"]);
    watchers.push(operator);
    operator.on("message", (data, binary) => {
      const message = binary ? {} : JSON.parse(data);
      if (message.op === "advertiseServices") seen.services = message.services.map((s) => s.name);
    });
    await until(() => seen.services.includes("/operator/stop"), "the operator's services", 20000);
    const page = await new Promise((done, failed) => get(view.url, (response) => { response.resume(); done(response.statusCode); }).on("error", failed));
    assert.equal(page, 200);
  } finally {
    for (const socket of silent) socket.destroy();
    for (const socket of watchers) socket.terminate();
    view.child.kill("SIGKILL");
  }
});

test("opened to a network, a name that is none of the machine's is refused", async () => {
  const view = await startView("run", "--view", "0", "--view-address", "0.0.0.0", "--quiet", "--speed", "1", "--seed", "1");
  const port = new URL(view.url).port;
  const asked = (host) => new Promise((done, failed) => {
    get({ host: "127.0.0.1", port, path: "/robot.urdf", headers: { Host: host } }, (response) => {
      response.resume();
      done(response.statusCode);
    }).on("error", failed);
  });
  try {
    assert.equal(await asked(`127.0.0.1:${port}`), 200);
    assert.equal(await asked(`${hostname()}:${port}`), 200);
    assert.equal(await asked(`elsewhere.example:${port}`), 403);
  } finally {
    view.child.kill("SIGKILL");
  }
});

test("a page from elsewhere is turned away, and so is who speaks no protocol of ours", async () => {
  const refused = (options, protocols) => new Promise((done) => {
    const socket = new WebSocket(lift.url.replace("http", "ws"), protocols, options);
    socket.on("unexpected-response", (_, response) => { done(response.statusCode); socket.terminate(); });
    socket.on("error", () => done("error"));
    socket.on("close", (code) => done(code));
  });
  assert.equal(await refused({ origin: "https://elsewhere.example" }, ["foxglove.sdk.v1"]), 403);
  assert.equal(await refused({ headers: { Host: "robot.example:80" } }, ["foxglove.sdk.v1"]), 403);
  assert.notEqual(await refused({}, ["chat"]), undefined);
});

test("a viewer's page that was allowed may read the robot's model; others may not", async () => {
  const view = await startView("run", "--view", "0", "--speed", "0", "--dry-run", "--seed", "1", "--allow-origin", "https://viewer.example");
  const asked = (origin) => new Promise((done, failed) => {
    get(new URL("robot.urdf", view.url), { headers: { Origin: origin } }, (response) => {
      assert.equal(response.statusCode, 200);
      response.resume();
      done(response.headers["access-control-allow-origin"]);
    }).on("error", failed);
  });
  assert.equal(await asked("https://viewer.example"), "https://viewer.example");
  assert.equal(await asked("https://elsewhere.example"), undefined);
  await view.end();
});
