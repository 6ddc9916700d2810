// The page in a real browser, while a simulated lift goes on.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { after, before, test } from "node:test";
import { launchBrowser } from "./browser.mjs";
import { scenario, startLift, startView, until } from "./running_lift.mjs";

const PICTURES = process.env.COLIFT_PICTURES ?? "pictures";
const RECORDING = "watched.mcap";
let browser, lift, page;

before(async () => {
  mkdirSync(PICTURES, { recursive: true });
  browser = await launchBrowser();
  // it is held up for ten minutes, so that the browser, however busy, stops it and it does not end before
  lift = await startLift("--speed", "3", "--allow-operator", "--record", RECORDING, "--set", "task.hold_s=600");
  page = await browser.newPage({ viewport: { width: 1366, height: 768 } });
  page.on("pageerror", (error) => { throw error; });
  // what is said for two seconds only is not missed by a browser that is busy
  await page.addInitScript(() => addEventListener("DOMContentLoaded", () => {
    const words = document.getElementById("shares");
    window.sharesSaid = [];
    new MutationObserver(() => window.sharesSaid.push(words.textContent)).observe(words, { childList: true });
  }));
  await page.goto(lift.url);
});
after(async () => {
  await browser?.close();
  lift?.child.kill("SIGKILL");
});

/** Part of the 3D picture's pixels that are not its background, 0 to 1. */
const litPixels = () => page.evaluate(() => {
  const canvas = document.getElementById("scene");
  const copy = document.createElement("canvas");
  copy.width = 200;
  copy.height = 150;
  const context = copy.getContext("2d");
  context.drawImage(canvas, 0, 0, 200, 150);
  const data = context.getImageData(0, 0, 200, 150).data;
  let lit = 0;
  for (let i = 0; i < data.length; i += 4)
    if (Math.abs(data[i] - data[0]) + Math.abs(data[i + 1] - data[1]) + Math.abs(data[i + 2] - data[2]) > 40) ++lit;
  return lit / (200 * 150);
});

test("the strip names the states as the lift goes through them", async () => {
  await page.waitForSelector("#link.connected");
  const words = () => page.$$eval("#strip li:not(.to-come) b", (list) => list.map((b) => b.textContent));
  for (const state of ["observe", "await-partner", "decide", "plan", "approach"])
    await until(async () => (await words()).includes(state), state, 120000);
  assert.notEqual(await page.textContent("#state"), "not connected");
});

test("the load's share is drawn while it is carried", async () => {
  const said = () => page.evaluate(() => window.sharesSaid.some((words) => /The robot carries [1-9]\d* N/.test(words)));
  await until(said, "a share", 120000);
  await page.screenshot({ path: `${PICTURES}/live_lift.png` });
});

test("the scene shows robot, cloud and grasps", async () => {
  await until(async () => (await litPixels()) > 0.05, "lit pixels", 60000);
});

/** Part of the 3D picture that a layer covers, 0 to 1. */
const covered = (layer) => page.evaluate(async (name) => {
  const canvas = document.getElementById("scene");
  const box = [...document.querySelectorAll("#layers label")].find((l) => l.textContent === name).querySelector("input");
  const picture = async () => {
    const asked = Number(canvas.dataset.touches);
    while (Number(canvas.dataset.drawn) < asked) await new Promise((later) => setTimeout(later, 10));
    const copy = document.createElement("canvas");
    copy.width = 400;
    copy.height = 300;
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0, 400, 300);
    return context.getImageData(0, 0, 400, 300).data;
  };
  const on = await picture();
  box.click();
  const off = await picture();
  box.click();
  let changed = 0;
  for (let i = 0; i < on.length; i += 4)
    if (Math.abs(on[i] - off[i]) + Math.abs(on[i + 1] - off[i + 1]) + Math.abs(on[i + 2] - off[i + 2]) > 15) ++changed;
  return changed / (400 * 300);
}, layer);

test("a click on a candidate says why", async () => {
  await page.waitForSelector("#candidates tr[data-id]");
  await page.locator("#candidates tr[data-id]", { hasText: "collision" }).first().click();
  const reason = await page.textContent("#reason");
  assert.match(reason, /^Grasp \d+: collision\. .{10,}/);
  await page.focus("#candidates");
  await page.keyboard.press("ArrowUp");
  assert.notEqual(await page.textContent("#reason"), reason);
  await page.screenshot({ path: `${PICTURES}/live_choice.png` });
});

test("collision world, partner, chosen gripper and path are drawn", async () => {
  for (const layer of ["map", "partner", "gripper", "path", "target", "candidates"])
    await until(async () => (await covered(layer)) > 0.0002, `the layer ${layer}`, 120000);
});

test("every device is there and alive", async () => {
  await page.waitForSelector("#device-list li");
  assert.deepEqual(await page.$$eval("#device-list b", (list) => list.map((b) => b.textContent)), ["arm", "hand", "camera"]);
});

test("what will move is announced before it does", async () => {
  await until(async () => /next: |please/.test(await page.textContent("#intent")), "an announcement", 60000);
});

test("light and dark, by key", async () => {
  const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const first = await background();
  await page.keyboard.press("t");
  assert.notEqual(await background(), first);
  await page.screenshot({ path: `${PICTURES}/live_other_theme.png` });
  await page.keyboard.press("t");
});

test("an operator's stop ends the run safely", async () => {
  const words = () => page.$$eval("#strip li:not(.to-come) b", (list) => list.map((b) => b.textContent));
  await until(async () => (await words()).includes("hold"), "hold", 120000);
  await page.click("#stop");
  await until(async () => ["stopped", "aborted", "done", "refused"].includes(await page.textContent("#state")), "the end", 60000);
  assert.equal(await lift.end(), 130);
});

test("somebody in the path: who is near, how fast the arm may be, and why it waits", async () => {
  // who stands in the path stays long enough for a browser that draws slowly
  const text = readFileSync(scenario("person_in_the_path"), "utf8"), stays = text.replace("leaves_s: 9.0", "leaves_s: 14.0");
  assert.notEqual(stays, text);
  writeFileSync("stays.yaml", stays);
  const blocked = await startView("run", "--view", "0", "--seed", "1", "--quiet", "--speed", "0.5", "--scenario", "stays.yaml");
  try {
    await page.goto(blocked.url);
    await page.waitForSelector("#link.connected");
    await until(async () => /^The arm waits: a person is \d\.\d\d m from the arm/.test(await page.textContent("#near")), "the wait", 120000);
    await page.screenshot({ path: `${PICTURES}/live_person.png` });
    await until(async () => (await covered("people")) > 0.002, "the layer people", 20000);
    await until(async () => /nobody near|of its speed|nearest/.test(await page.textContent("#near")), "that it continues", 120000);
  } finally {
    blocked.child.kill("SIGKILL");
  }
});

test("after a stop an operator confirms on the page, and the lift is made", async () => {
  const confirmed = await startView("run", "--view", "0", "--seed", "1", "--quiet", "--speed", "0.7", "--allow-operator", "--set", "monitor.resume=false",
    "--scenario", scenario("person_in_the_path"));
  try {
    await page.goto(confirmed.url);
    await page.waitForSelector("#link.connected");
    await until(async () => /press Continue/.test(await page.textContent("#near")), "the question", 120000);
    await page.screenshot({ path: `${PICTURES}/live_confirm.png` });
    await page.click("#continue");
    await until(async () => (await page.textContent("#state")) === "done", "the end of the lift", 120000);
  } finally {
    confirmed.child.kill("SIGKILL");
  }
});

test("the recording of it is watched on the same page", async () => {
  const replay = await startView("log", "replay", RECORDING, "--view", "0", "--speed", "0");
  try {
    await page.goto(replay.url);
    await until(async () => (await page.textContent("#name")).includes(RECORDING), "the recording's name");
    await until(() => /^the same, bit for bit/m.test(replay.output), "the replay's end", 60000);
    await until(async () => (await page.$("#candidates tr[data-id]")) !== null, "the candidates");  // drawn after the last message
    assert.deepEqual(await page.$$eval("#device-list b", (list) => list.map((b) => b.textContent)), ["arm", "hand", "camera"]);
    assert.ok(["stopped", "aborted", "refused", "done"].includes(await page.textContent("#state")));
    await until(async () => (await litPixels()) > 0.05, "lit pixels");
    await page.screenshot({ path: `${PICTURES}/live_replay.png` });
    assert.equal(await replay.end(), 0); // the last state stays until it is told to go
  } finally {
    replay.child.kill("SIGKILL");
  }
});
