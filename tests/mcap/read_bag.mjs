// Holds a bag that `colift log export --format ros2` made against readers that are not ours: Foxglove's parser of message
// definitions, its decoder of CDR, and the public definitions of ROS 2 (Humble).
//   node read_bag.mjs FOLDER

import { open, readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import assert from "node:assert/strict";

const require = createRequire(import.meta.url);
const { McapIndexedReader } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader, MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const fzstd = require("fzstd");

const folder = process.argv[2];
const decompressHandlers = { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) };
const nanoseconds = (stamp) => BigInt(stamp.sec) * 1_000_000_000n + BigInt(stamp.nsec ?? stamp.nanosec);
const withoutMsg = (type) => type.replace("/msg/", "/");

/** Members that differ from the public definition of a type. */
function otherMembers(ours, theirs) {
  const members = (d) =>
    d.definitions
      .filter((m) => !m.isConstant)
      .map((m) => `${withoutMsg(m.type)}${m.isArray ? `[${m.arrayLength ?? ""}]` : ""} ${m.name}`);
  assert.deepEqual(members(ours), members(theirs), ours.name);
}

class File {
  constructor(handle) {
    this.handle = handle;
  }
  async size() {
    return BigInt((await this.handle.stat()).size);
  }
  async read(offset, size) {
    const bytes = new Uint8Array(Number(size));
    await this.handle.read(bytes, 0, Number(size), Number(offset));
    return bytes;
  }
}

const handle = await open(`${folder}/bag_0.mcap`);
const reader = await McapIndexedReader.Initialize({ readable: new File(handle), decompressHandlers });
assert.equal(reader.header.profile, "ros2");

const codecs = new Map();
let compared = 0;
for (const [id, schema] of reader.schemasById) {
  assert.equal(schema.encoding, "ros2msg");
  const definitions = parse(new TextDecoder().decode(schema.data), { ros2: true });
  for (const d of definitions) {
    const name = d.name ?? withoutMsg(schema.name);
    const theirs = ros2humble[name] ?? ros2humble[name.replace("/", "/msg/")];
    if (!theirs) {
      assert.ok(name.startsWith("colift_msgs/"), `${name} is no message of ROS 2`);
      continue;
    }
    otherMembers({ ...d, name }, theirs);
    ++compared;
  }
  codecs.set(id, { reader: new MessageReader(definitions), writer: new MessageWriter(definitions) });
}
assert.ok(compared > 15, `only ${compared} definitions were compared`);

const counts = {}, infos = new Set(), images = new Set();
let transforms = new Set(), last = {};
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  assert.equal(channel.messageEncoding, "cdr");
  const { reader: decode, writer } = codecs.get(channel.schemaId);
  const value = decode.readMessage(message.data);
  counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
  last[channel.topic] = value;
  // every byte is one of the message: written once more it is the same
  assert.deepEqual(Buffer.from(writer.writeMessage(value)), Buffer.from(message.data), channel.topic);
  if (value.header) {
    const apart = Number(nanoseconds(value.header.stamp) - message.logTime) / 1e9;
    assert.ok(Math.abs(apart) < 1, `${channel.topic}: stamp and log time are ${apart} s apart`);
  }
  if (channel.topic === "/colift/depth/camera_info") infos.add(nanoseconds(value.header.stamp));
  if (channel.topic === "/colift/depth/image_raw") {
    images.add(nanoseconds(value.header.stamp));
    assert.equal(value.data.length, value.step * value.height);
  }
  if (channel.topic.startsWith("/tf")) for (const t of value.transforms) transforms.add(t.child_frame_id);
}

assert.deepEqual(images, infos, "every image has its camera model, with the same stamp");
assert.ok(images.size > 50);
assert.ok(Date.now() / 1000 - last["/joint_states"].header.stamp.sec < 86400, "stamps are of today");
assert.equal(last["/joint_states"].name.filter((n) => /^arm_[1-7]$/.test(n)).length, 7);
assert.ok(last["/joint_states"].position.every(Number.isFinite));
assert.ok(last["/robot_description"].data.includes("<robot"));
assert.equal(counts["/robot_description"], 1);
assert.ok(transforms.has("object") && transforms.has("partner"));
assert.equal([...reader.channelsById.values()].filter((c) => c.topic === "/tf").length, 1);
assert.ok(transforms.has("camera") && transforms.size > 10);
assert.ok(last["/colift/decision"].candidates.some((c) => c.id === last["/colift/decision"].chosen));
assert.ok(last["/colift/cloud"].data.length > 1000);

// what a player of bags offers again
const latched = [...reader.channelsById.values()].filter((c) => /durability: 1/.test(c.metadata.get("offered_qos_profiles")));
assert.deepEqual(
  latched.map((c) => c.topic).sort(),
  ["/colift/decision", "/colift/map", "/colift/scene", "/robot_description", "/tf_static"],
);
const metadata = await readFile(`${folder}/metadata.yaml`, "utf8");
const total = Object.values(counts).reduce((a, b) => a + b, 0);
assert.match(metadata, new RegExp(`\\n  message_count: ${total}\\n`));
for (const [topic, count] of Object.entries(counts))
  assert.ok(metadata.includes(`name: ${topic}\n`) && metadata.includes(`message_count: ${count}\n`), topic);
console.log(`${total} messages on ${Object.keys(counts).length} topics decoded and encoded again; ${compared} definitions as in ROS 2`);
