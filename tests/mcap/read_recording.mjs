// Holds one of CoLift's recordings against the format's own reader (@mcap/core) and Foxglove's own schemas.
//   node read_recording.mjs FILE.mcap

import { open } from "node:fs/promises";
import { createRequire } from "node:module";
import assert from "node:assert/strict";

const require = createRequire(import.meta.url);
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const fzstd = require("fzstd");
const foxglove = require("@foxglove/schemas/jsonschema");

const path = process.argv[2];
const decompressHandlers = { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) };

const nanoseconds = (stamp) => BigInt(stamp.sec) * 1_000_000_000n + BigInt(stamp.nsec);

/** The properties of our schema that Foxglove's has not, or of another type. */
function strangers(ours, theirs, where) {
  if (ours.type === "array") return theirs.type === "array" ? strangers(ours.items, theirs.items, where + "[]") : [where];
  if (ours.type === "object") {
    if (!ours.properties) return [];
    if (!theirs.properties) return [where];
    return Object.entries(ours.properties).flatMap(([key, value]) =>
      theirs.properties[key] ? strangers(value, theirs.properties[key], `${where}.${key}`) : [`${where}.${key}`],
    );
  }
  if (theirs.oneOf) return ours.type === "integer" ? [] : [where];
  return ours.type === theirs.type ? [] : [where];
}

/** What a message breaks of a schema: missing required keys, other types. */
function broken(value, schema, where) {
  if (schema.oneOf) return schema.oneOf.some((one) => one.const === value) ? [] : [`${where}=${value}`];
  switch (schema.type) {
    case "object":
      if (typeof value !== "object" || value === null) return [where];
      return [
        ...(schema.required ?? []).filter((key) => !(key in value)).map((key) => `${where}.${key} is missing`),
        ...Object.entries(value).flatMap(([key, inner]) =>
          schema.properties?.[key] ? broken(inner, schema.properties[key], `${where}.${key}`) : [],
        ),
      ];
    case "array":
      return Array.isArray(value) ? value.flatMap((inner, i) => broken(inner, schema.items, `${where}[${i}]`)) : [where];
    case "integer":
      return Number.isInteger(value) ? [] : [where];
    case "number":
      return typeof value === "number" ? [] : [where];
    case "string":
      return typeof value === "string" ? [] : [where];
    case "boolean":
      return typeof value === "boolean" ? [] : [where];
    default:
      return [];
  }
}

/** sensor_msgs/msg/Image in CDR, little endian, as Foxglove's reader takes it: numbers at multiples of their size. */
function image(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  assert.equal(view.getUint32(0, false), 0x00010000, "little-endian CDR");
  let at = 4;
  const u32 = () => {
    at += (4 - ((at - 4) % 4)) % 4;
    at += 4;
    return view.getUint32(at - 4, true);
  };
  const take = (length) => bytes.subarray(at, (at += length));
  const text = () => {
    const found = take(u32());
    assert.equal(found.at(-1), 0);
    return new TextDecoder().decode(found.subarray(0, -1));
  };
  const stamp = { sec: u32(), nanosec: u32() };
  const frameId = text();
  const [height, width] = [u32(), u32()];
  const encoding = text();
  const bigEndian = take(1)[0];
  const step = u32();
  const data = take(u32());
  assert.equal(at, bytes.byteLength, "nothing is left");
  return { stamp, frameId, height, width, encoding, bigEndian, step, data };
}

const file = await open(path, "r");
const { size } = await file.stat();
const readable = {
  size: async () => BigInt(size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    await file.read(bytes, 0, Number(length), Number(offset));
    return bytes;
  },
};

// by its indexes
const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
assert.equal(reader.header.library, "colift");
assert.ok(reader.statistics.messageCount > 100n);
assert.equal(reader.statistics.channelMessageCounts.size, reader.channelsById.size);
assert.equal(reader.chunkIndexes.length, reader.statistics.chunkCount);

for (const schema of reader.schemasById.values()) {
  if (schema.name === "std_msgs/msg/String") {
    assert.equal(schema.encoding, "ros2msg");
    const fields = parse(new TextDecoder().decode(schema.data), { ros2: true })[0].definitions;
    assert.deepEqual(fields.map((f) => [f.name, f.type]), ros2humble["std_msgs/String"].definitions.map((f) => [f.name, f.type]));
    continue;
  }
  if (schema.name === "sensor_msgs/msg/Image") {
    assert.equal(schema.encoding, "ros2msg");
    continue;
  }
  assert.equal(schema.encoding, "jsonschema");
  if (!schema.name.startsWith("foxglove.")) continue;
  const theirs = foxglove[schema.name.slice("foxglove.".length)];
  assert.ok(theirs, `${schema.name} is one of Foxglove's`);
  assert.deepEqual(strangers(JSON.parse(new TextDecoder().decode(schema.data)), theirs, schema.name), []);
}

const counts = new Map();
const frames = new Set(), exposures = new Set(), tracked = new Map(), models = [];
let lastTime = 0n;
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  counts.set(channel.topic, (counts.get(channel.topic) ?? 0) + 1);
  assert.ok(message.logTime >= lastTime, "indexed reading goes by time");
  lastTime = message.logTime;
  if (channel.topic === "/camera/depth") {
    const { frameId, width, height, encoding, bigEndian, step, data } = image(message.data);
    assert.deepEqual({ frameId, width, height, encoding, bigEndian, step },
      { frameId: "camera", width: 640, height: 480, encoding: "16UC1", bigEndian: 0, step: 1280 });
    assert.equal(data.byteLength, step * height);
    const measured = new Uint16Array(data.slice().buffer).filter((mm) => mm > 400 && mm < 10000).length;
    assert.ok(measured > 0.5 * width * height, "half of the pixels have a depth in the Kinect's range");
  }
  if (channel.topic === "/robot_description") {
    const definition = parse(new TextDecoder().decode(reader.schemasById.get(channel.schemaId).data), { ros2: true });
    models.push(new MessageReader(definition).readMessage(message.data).data);
  }
  if (channel.messageEncoding !== "json") continue;
  const value = JSON.parse(new TextDecoder().decode(message.data));
  if (channel.topic === "/tf") for (const t of value.transforms) frames.add(t.child_frame_id);
  if (channel.topic === "/camera/frame") exposures.add(BigInt(value.exposed_at));
  if (channel.topic === "/tf/tracked") {
    assert.ok(value.transforms.length > 0, "nobody says that nothing is seen");
    for (const t of value.transforms) {
      const at = nanoseconds(t.timestamp);
      assert.equal(t.parent_frame_id, "world");
      assert.ok(exposures.has(at), `${t.child_frame_id}: its stamp is that of a picture that has come`);
      assert.ok(message.logTime - at < 1_000_000_000n, `${t.child_frame_id} is not of an old picture`);
      assert.ok(at > (tracked.get(t.child_frame_id)?.at(-1) ?? -1n), `${t.child_frame_id}: later and later`);
      tracked.set(t.child_frame_id, [...(tracked.get(t.child_frame_id) ?? []), at]);
    }
  }
  const schema = reader.schemasById.get(channel.schemaId);
  const theirs = foxglove[schema.name.replace("foxglove.", "")];
  if (schema.name.startsWith("foxglove.")) assert.deepEqual(broken(value, theirs, channel.topic), []);
}
for (const topic of ["/tf", "/joint_states", "/camera/depth", "/camera/frame", "/camera/calibration", "/cloud", "/scene", "/map", "/log",
  "/task/status", "/task/change", "/decision", "/plan", "/devices", "/arm/timing", "/load", "/inputs"])
  assert.ok(counts.get(topic) > 0, `${topic} has messages`);

// what a viewer needs to draw the robot: its model, once, and a frame for each of its links
assert.equal(models.length, 1);
const links = [...models[0].matchAll(/<link name="(\w+)"/g)].map((found) => found[1]);
assert.ok(links.length > 15);
for (const link of links) assert.ok(link === "world" || frames.has(link), `/tf has no ${link}`);
assert.ok(!/<mesh/.test(models[0]), "no mesh that only a file beside it would hold");
assert.deepEqual([...tracked.keys()].sort(), ["object", "partner"]);
assert.ok(tracked.get("partner").length > 3, "the partner's hand is followed");

const attachments = [];
for await (const attachment of reader.readAttachments()) attachments.push(attachment.name);
for (const name of ["config.yaml", "calibration.json", "robot.urdf", "scenario.yaml", "run.json"])
  assert.ok(attachments.includes(name), `${name} is attached`);
const metadata = new Map();
for await (const record of reader.readMetadata()) metadata.set(record.name, record.metadata);
assert.equal(metadata.get("colift.run").get("schema"), "colift.recording/1");
assert.equal(metadata.get("colift.recorder").get("lost_queue"), "0");

// from the front, with every checksum
const stream = new McapStreamReader({ includeChunks: true, decompressHandlers, validateCrcs: true });
let streamed = 0n;
const step = 1 << 20;
for (let offset = 0; offset < size; offset += step) {
  stream.append(await readable.read(offset, Math.min(step, size - offset)));
  for (let record; (record = stream.nextRecord()); ) if (record.type === "Message") streamed++;
}
assert.ok(stream.done());
assert.equal(streamed, reader.statistics.messageCount);
await file.close();

console.log(`${path}: ${streamed} messages on ${counts.size} channels, ${attachments.length} attachments: as the format says`);
