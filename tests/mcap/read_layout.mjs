// Holds the layout for Foxglove and Lichtblick against a recording: every topic is there, every field that is drawn is in its schema, and
// every panel is placed once.
//   node read_layout.mjs LAYOUT.json FILE.mcap

import { open, readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import assert from "node:assert/strict";

const require = createRequire(import.meta.url);
const { McapIndexedReader } = require("@mcap/core");
const fzstd = require("fzstd");

const { configById, layout } = JSON.parse(await readFile(process.argv[2], "utf8"));
const handle = await open(process.argv[3]);
const reader = await McapIndexedReader.Initialize({
  readable: {
    size: async () => BigInt((await handle.stat()).size),
    read: async (offset, size) => {
      const bytes = new Uint8Array(Number(size));
      await handle.read(bytes, 0, Number(size), Number(offset));
      return bytes;
    },
  },
  decompressHandlers: { zstd: (bytes, size) => fzstd.decompress(bytes, new Uint8Array(Number(size))) },
});
const channels = new Map([...reader.channelsById.values()].map((c) => [c.topic, reader.schemasById.get(c.schemaId)]));

/** The topic of a message path ("/task/status.state"), and that each of its fields is in the topic's schema. */
function check(path, types) {
  const [topic, ...fields] = path.split(".");
  const schema = channels.get(topic);
  assert.ok(schema, `${path}: the recording has no ${topic}`);
  if (fields.length === 0 && !types) return;  // the whole message, whose type is not always JSON's
  let at = JSON.parse(new TextDecoder().decode(schema.data));
  for (const field of fields) {
    at = at.properties?.[field];
    assert.ok(at, `${path}: the schema of ${topic} has no ${field}`);
  }
  if (types) assert.ok([at.type].flat().some((t) => types.includes(t)), `${path} is of type ${at.type}`);
}

const placed = [];
function place(node) {
  if (typeof node === "string") {
    placed.push(node);
    for (const tab of configById[node]?.tabs ?? []) place(tab.layout);
    return;
  }
  place(node.first), place(node.second);
}
place(layout);
assert.deepEqual([...placed].sort(), Object.keys(configById).sort(), "every panel is placed once");

let drawn = 0;
for (const [id, panel] of Object.entries(configById)) {
  const kind = id.split("!")[0];
  if (kind === "Plot") for (const { value } of panel.paths) check(value, ["number", "integer"]), ++drawn;
  if (kind === "StateTransitions") for (const { value } of panel.paths) check(value, ["string"]), ++drawn;
  for (const topic of Object.keys(panel.topics ?? {})) check(topic), ++drawn;
  for (const topic of [panel.topicToRender, panel.topicPath, panel.imageMode?.imageTopic, panel.imageMode?.calibrationTopic])
    if (topic) check(topic), ++drawn;
}
assert.ok(drawn > 15);
console.log(`${placed.length} panels of the layout draw ${drawn} topics and fields, all of them there`);
