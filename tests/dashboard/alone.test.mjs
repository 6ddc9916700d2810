// The page in a real browser, on messages of the test's own choice: what is drawn, said, and where it stands.
import assert from "node:assert/strict";
import { mkdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { after, before, test } from "node:test";
import { launchBrowser } from "./browser.mjs";
import { BOX, decision, load, playedRun, scene, status, tactile } from "./played_run.mjs";
import { until } from "./running_lift.mjs";

const PICTURES = process.env.COLIFT_PICTURES ?? "pictures";
const PAGE = process.env.COLIFT_PAGE ?? "dashboard";
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
const VERDICTS = ["chosen", "ok", "collision", "unreachable", "too-wide", "unstable", "over-limit", "near-partner"];
const SIZES = [[390, 844], [768, 1024], [1400, 900]];
const robot = { "/robot.urdf": readFileSync(process.env.COLIFT_URDF ?? "robot.urdf") };
let browser, run, page, errors = [];

// one page sees one run after the other, as it does when a program is started again on the same port
before(async () => {
  mkdirSync(PICTURES, { recursive: true });
  browser = await launchBrowser();
  run = await playedRun(PAGE);
  page = await browser.newPage();
  page.on("pageerror", (error) => errors.push(error.message));
  await page.goto(run.url);
});
after(async () => {
  await browser?.close();
  run?.end();
});

/** The page beside a run that stands in the middle of its lift. */
async function watched(more = {}, viewport = { width: 1400, height: 900 }) {
  errors = [];
  await page.setViewportSize(viewport);
  await run.begin({ operates: true, documents: robot, ...more });
  run.say("/scene", scene(VERDICTS));
  run.say("/decision", decision(VERDICTS));
  run.say("/task/change", { t: 0, state: "observe", because: "the run begins" });
  run.say("/task/change", { t: 3.5, state: "lift", because: "the partner has held still for 0.5 s: the robot leads" }, 3.5);
  run.say("/task/status", status("lift"), 4);
  run.say("/load", load(0), 4);
  run.say("/devices", { devices: ["arm", "hand", "camera"].map((name) => ({ name, state: "streaming", accepted: 1000, rejected: 0, last_error: "" })) }, 4);
  await page.evaluate(() => { document.querySelector("main").scrollTop = 0; });
  await page.waitForSelector("#link.connected");
  await until(async () => (await page.textContent("#state")) === "lift", "the state");
  return () => assert.deepEqual(errors, []);
}

/** Top and bottom row of what a layer draws, in pixels of the page. */
const rows = (layer) => page.evaluate(async (name) => {
  const canvas = document.getElementById("scene");
  const boxes = [...document.querySelectorAll("#layers label")];
  const toggle = (label, on) => { const box = label.querySelector("input"); if (box.checked !== on) box.click(); };
  const were = boxes.map((label) => label.querySelector("input").checked);
  for (const label of boxes) toggle(label, false);
  const picture = async () => {
    const asked = Number(canvas.dataset.touches);
    while (Number(canvas.dataset.drawn) < asked) await new Promise((later) => setTimeout(later, 10));
    const copy = document.createElement("canvas");
    copy.width = canvas.clientWidth;
    copy.height = canvas.clientHeight;
    const context = copy.getContext("2d");
    context.drawImage(canvas, 0, 0, copy.width, copy.height);
    return context.getImageData(0, 0, copy.width, copy.height).data;
  };
  const mine = boxes.find((label) => label.textContent === name);
  const without = await picture();
  toggle(mine, true);
  const with_it = await picture();
  boxes.forEach((label, i) => toggle(label, were[i]));
  let top = Infinity, bottom = -Infinity;
  for (let i = 0; i < with_it.length; i += 4) {
    if (Math.abs(with_it[i] - without[i]) + Math.abs(with_it[i + 1] - without[i + 1]) + Math.abs(with_it[i + 2] - without[i + 2]) < 30) continue;
    const row = Math.floor(i / 4 / canvas.clientWidth);
    top = Math.min(top, row);
    bottom = Math.max(bottom, row);
  }
  return { top, bottom, height: canvas.clientHeight };
}, layer);

/** How far a layer has gone up in the picture (m): seen from the side, from 3 m, at 45 degrees of view. */
async function risen(layer, before) {
  const now = await rows(layer);
  return (before.bottom - now.bottom) * 2 * (3 - BOX.size.y / 2) * Math.tan(Math.PI / 8) / now.height;
}

async function fromTheSide() {
  await page.focus("#scene");
  await page.keyboard.press("2");
}
const settled = async (mm) =>
  until(async () => Math.abs(Number(await page.evaluate(() => document.getElementById("scene").dataset.raisedMm)) - mm) < 0.2, `a rise of ${mm} mm`);

test("the drawn object rises by 5 cm as the palm does, and its partner with it", async () => {
  const end = await watched({}, { width: 700, height: 1600 });
  run.say("/load", load(null), 4.05); // no words above the object: they would be measured with it
  await fromTheSide();
  await settled(0);
  const object = await rows("target"), partner = await rows("partner");
  run.say("/load", load(0.05), 4.1);
  await settled(50);
  await page.screenshot({ path: `${PICTURES}/alone_raised.png` });
  for (const [layer, before] of [["target", object], ["partner", partner]]) {
    const up = await risen(layer, before);
    assert.ok(Math.abs(up - 0.05) < 0.01, `the ${layer} went up by ${up} m`);
  }
  end();
});

test("where the run publishes the object's pose, that counts: raised and tilted", async () => {
  const end = await watched({}, { width: 700, height: 1600 });
  run.say("/load", load(null), 4.05);
  await fromTheSide();
  const before = await rows("target");
  const at = (z, turn) => ({ transforms: [{ parent_frame_id: "world", child_frame_id: "object", translation: { ...BOX.center, z },
    rotation: { x: 0, y: Math.sin(turn / 2), z: 0, w: Math.cos(turn / 2) } }] });
  run.say("/tf", at(BOX.center.z + 0.05, 0), 4.1);
  run.say("/load", load(0.01), 4.2);
  await settled(50);
  const up = await risen("target", before);
  assert.ok(Math.abs(up - 0.05) < 0.01, `up by ${up} m`);
  const level = await rows("target");
  run.say("/tf", at(BOX.center.z + 0.05, 0.2), 4.3);
  await until(async () => { const now = await rows("target"); return now.bottom > level.bottom + 8; }, "a tilt that is seen");
  end();
});

test("figures are said as people read them", async () => {
  const end = await watched();
  const says = async (message, words) => {
    run.say("/load", message, message.at);
    await until(async () => words.test(await page.textContent("#shares")), `${words} instead of ${await page.textContent("#shares")}`, 5000);
  };
  await says({ ...load(0.05), at: 5 }, /^The robot carries 21 N, 46 % of the load \(predicted 45 %\), tilt 0\.3°, 5\.0 cm up$/);
  await says({ ...load(-0.0001, { load_n: -1, share: -0.03, tilt_deg: -0.01 }), at: 6 }, /^The robot carries nothing, tilt 0\.0°, not raised$/);
  await says({ ...load(-0.004), at: 7 }, /0\.4 cm below the grasp$/);
  run.say("/task/status", status("lift", { force: { on: true, felt: [-0.2, 0, -0.3], sideways_limit_n: 30, up_limit_n: 40, down_limit_n: 40, exceeded: false } }), 8);
  await until(async () => /0 of 30 N sideways, 0 of 40 N down/.test(await page.textContent("#felt")), "the force");
  assert.ok(!/-0(\.0)? /.test(await page.textContent("main")));
  end();
});

test("who leads is said, and a recording that does not know it stays silent", async () => {
  const end = await watched();
  await until(async () => (await page.textContent("#leads")) === "robot leads", "the leader");
  run.say("/load", load(0.02, { leads: "partner" }), 5);
  await until(async () => (await page.textContent("#leads")) === "partner leads", "the other leader");
  run.say("/load", load(0.02, { leads: undefined }), 6);
  await until(() => page.locator("#leads").isHidden(), "silence");
  end();
});

test("tactile cells where the hand has any, and words where it has none", async () => {
  const end = await watched();
  assert.match(await page.textContent("#touch"), /^no tactile data/);
  assert.equal(await page.locator("#tactile i").count(), 0);
  run.say("/hand/tactile", tactile(6), 5);
  await until(async () => (await page.textContent("#touch")) === "touches with F1, F2, F3, palm", "the touch");
  assert.equal(await page.locator("#tactile figure").count(), 4);
  assert.equal(await page.locator("#tactile i").count(), 96);
  const shades = await page.$$eval("#tactile i", (cells) => new Set(cells.map((c) => getComputedStyle(c).backgroundColor)).size);
  assert.ok(shades >= 2, "pressed cells look different");
  // a cell that does not speak, and a list that is too short
  run.say("/hand/tactile", { arrays: [{ name: "F1", at: 2, force_n: null, cells: [null, 1] }], palm_touches: false }, 6);
  await until(async () => (await page.locator("#tactile i.absent").count()) === 23, "the silent cells");
  await page.screenshot({ path: `${PICTURES}/alone_tactile.png` });
  end();
});

test("the camera's picture shows object, grasp and partner where they are", async () => {
  const end = await watched();
  const width = 80, height = 60, depth = Buffer.alloc(2 * width * height);
  for (let i = 0; i < width * height; ++i) depth.writeUInt16LE(1500, 2 * i);
  run.say("/camera/calibration", { width: 160, height: 120, K: [140, 0, 80, 0, 140, 60, 0, 0, 1] });
  run.say("/camera/preview", { width, height, encoding: "16UC1", data: depth.toString("base64") });
  // looks down from above the object
  run.say("/tf", { transforms: [{ parent_frame_id: "world", child_frame_id: "camera", translation: { x: 0.8, y: 0, z: 2.2 }, rotation: { x: 1, y: 0, z: 0, w: 0 } }] });
  const orange = () => page.evaluate(() => {
    const canvas = document.getElementById("camera-picture");
    if (canvas.hidden) return 0;
    const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i] > 150 && data[i + 2] < 90) ++count;
    return count;
  });
  await until(async () => (await orange()) > 30, "the object's edges");
  // a picture that says of itself what is not so is not drawn
  run.say("/camera/preview", { width: 4000, height: 4000, encoding: "16UC1", data: "AAAA" });
  run.say("/camera/preview", { width, height, encoding: "rgb8", data: "AAAA" });
  await until(async () => (await orange()) > 30, "the picture before");
  await page.locator("#camera").screenshot({ path: `${PICTURES}/alone_camera.png` });
  end();
});

test("verdicts differ in shape, not in colour alone", async () => {
  const end = await watched();
  const signs = await page.$$eval("#candidates .verdict", (list) => list.map((v) => getComputedStyle(v, "::before").content));
  assert.equal(new Set(signs).size, VERDICTS.length);
  end();
});

/** Pairs of boxes with words or controls in them that cover each other in part. */
const overlaps = () => page.evaluate(() => {
  const leaves = [...document.querySelectorAll("body *")].filter((e) => {
    if (e.closest("svg, .uplot, script")) return false;
    const own = [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim() !== "");
    return (own || ["BUTTON", "INPUT", "CANVAS", "SELECT"].includes(e.tagName)) && e.checkVisibility();
  });
  /** What is seen of it: less than its box where something around it scrolls. */
  const seen = (e) => {
    let { left, top, right, bottom } = e.getBoundingClientRect();
    for (let p = e.parentElement; p; p = p.parentElement) {
      if (getComputedStyle(p).overflow === "visible") continue;
      const b = p.getBoundingClientRect();
      [left, top, right, bottom] = [Math.max(left, b.left), Math.max(top, b.top), Math.min(right, b.right), Math.min(bottom, b.bottom)];
    }
    return { left, top, right, bottom };
  };
  const name = (e) => `${e.tagName.toLowerCase()}#${e.id} "${(e.textContent ?? "").trim().slice(0, 30)}"`;
  const boxes = leaves.map((e) => [e, seen(e)]).filter(([, b]) => b.right - b.left > 1 && b.bottom - b.top > 1);
  const found = [];
  for (let i = 0; i < boxes.length; ++i)
    for (let j = i + 1; j < boxes.length; ++j) {
      const [a, p] = boxes[i], [b, q] = boxes[j];
      if (a.contains(b) || b.contains(a)) continue;
      const w = Math.min(p.right, q.right) - Math.max(p.left, q.left), h = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top);
      if (w > 1.5 && h > 1.5) found.push(`${name(a)} and ${name(b)}: ${w.toFixed(0)} x ${h.toFixed(0)}`);
    }
  const wide = document.documentElement.scrollWidth - innerWidth;
  if (wide > 0) found.push(`the page is ${wide} px wider than the window`);
  for (const box of document.querySelectorAll("section, header, #actions")) {
    const b = box.getBoundingClientRect();
    if (b.left < -1 || b.right > innerWidth + 1) found.push(`${name(box)} leaves the window`);
  }
  return found;
});

/** What axe finds, in both themes. */
async function axeFinds() {
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(AXE);
  const found = [];
  for (let i = 0; i < 2; ++i) {
    const { violations } = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
    const theme = await page.evaluate(() => document.documentElement.dataset.theme);
    found.push(...violations.map((v) => `${theme}, ${v.id}: ${v.nodes.map((n) => n.html.slice(0, 90)).join(" | ")}`));
    await page.keyboard.press("t");
  }
  return found;
}

for (const [width, height] of SIZES)
  test(`at ${width} px nothing overlaps, with all that can be shown, from top to bottom, and axe finds nothing`, async () => {
    const end = await watched({ name: "CoLift, recording a.mcap" }, { width, height });
    run.say("/hand/tactile", tactile(6), 5);
    run.say("/load", load(0.05), 5);
    run.say("/task/intent", { t: 5, motion: "lift", in_s: 0.5, says: "the arm lifts the object" }, 5);
    run.say("/log", { timestamp: { sec: 1, nsec: 0 }, level: 3, message: "the partner's hand is hidden by his own body", name: "task" });
    await until(async () => (await page.locator("#tactile i").count()) === 96, "the cells");
    for (let part = 0; part < 12; ++part) {
      assert.deepEqual(await overlaps(), [], `after ${part} screens`);
      await page.screenshot({ path: `${PICTURES}/alone_${width}_${part}.png` });
      const more = await page.evaluate(() => {
        const main = document.querySelector("main"), was = main.scrollTop;
        main.scrollTop += 0.8 * main.clientHeight;
        return main.scrollTop > was;
      });
      if (!more) break;
    }
    assert.deepEqual(await axeFinds(), []);
    end();
  });

test("on a phone what is waited for is the largest line, and Stop is where the thumb is", async () => {
  const end = await watched({}, { width: 390, height: 844 });
  const sizes = await page.evaluate(() => [...document.querySelectorAll("body *")]
    .filter((e) => e.checkVisibility() && [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim() !== ""))
    .map((e) => [parseFloat(getComputedStyle(e).fontSize), e.id]).sort((a, b) => b[0] - a[0]));
  assert.equal(sizes[0][1], "waits");
  assert.ok(sizes[0][0] > sizes[1][0]);
  const stop = await page.locator("#stop").boundingBox();
  assert.ok(stop.height >= 44 && stop.width >= 120, "large enough");
  assert.ok(stop.y > 844 * 2 / 3 && stop.y + stop.height <= 844, "in the lower third, in the window");
  await page.evaluate(() => { document.querySelector("main").scrollTop = 1e6; });
  assert.deepEqual(await page.locator("#stop").boundingBox(), stop);
  await page.tap("#stop").catch(() => page.click("#stop"));
  await until(() => run.calls.includes(1), "the stop");
  end();
});

test("Continue can be pressed only while the arm waits for a confirmation, by an operator, and the page says so", async () => {
  const waits = (may_confirm) => {
    const { separation } = status("lift");
    run.say("/task/status", status("lift", { separation: { ...separation, waits: true, speed_scale: 0, ...(may_confirm ? { may_confirm } : {}),
      because: may_confirm ? "nobody is near any more; the arm stopped for a person" : "a person is 0.42 m from the arm" } }), 5);
  };
  const disabled = () => page.evaluate(() => document.getElementById("continue").disabled);
  const end = await watched();
  assert.equal(await disabled(), true); // nothing waits
  waits(false);
  await until(async () => /^The arm waits: a person/.test(await page.textContent("#near")), "who is near");
  assert.equal(await disabled(), true);
  waits(true);
  await until(async () => !(await disabled()), "the button");
  assert.match(await page.textContent("#near"), /^The arm waits for confirmation, press Continue: nobody is near any more/);
  await page.click("#continue");
  await until(() => run.calls.includes(3), "the confirmation");
  waits(false);
  await until(disabled, "that it cannot be pressed again");
  end();

  const watching = await watched({ operates: false });
  waits(true);
  await until(async () => /press Continue/.test(await page.textContent("#near")), "the words");
  assert.equal(await disabled(), true);
  watching();
});

/** Each picture takes so much longer (ms), on the processor as where there is no graphics card. */
const slowPictures = (ms) => page.evaluate((ms) => {
  const gl = WebGL2RenderingContext.prototype;
  window.clearAtOnce ??= gl.clear;
  gl.clear = function (...what) {
    for (const until = performance.now() + ms; performance.now() < until;);
    return window.clearAtOnce.apply(this, what);
  };
}, ms);

test("a page that draws slowly takes its messages, shows the newest, and its Stop gets through", async () => {
  const end = await watched();
  await slowPictures(300);
  const pictures = () => page.evaluate(() => Number(document.getElementById("scene").dataset.drawn));
  let said = 0, height = 0;
  const chatter = setInterval(() => {
    height = 0.0001 * (++said % 500);
    run.say("/scene", scene(VERDICTS), 10 + said / 50);
    run.say("/load", load(height), 10 + said / 50);
    run.say("/task/status", status("lift", { t: 10 + said / 50, waits_for: `message ${said}` }), 10 + said / 50);
  }, 20);
  try {
    const before = await pictures();
    await until(async () => (await pictures()) > before + 3, "slow pictures");
    const asked = Date.now();
    await page.click("#stop");
    await until(() => run.stops > 0 && run.calls.includes(1), "the stop, by both ways", 5000);
    assert.ok(Date.now() - asked < 5000, `${Date.now() - asked} ms`);
    const then = said;
    await until(async () => Number(/\d+/.exec(await page.textContent("#waits"))?.[0]) >= then, "the newest message, not those before it", 5000);
  } finally {
    clearInterval(chatter);
    await slowPictures(0);
  }
  end();
});

test("a lost link is said in large words, Stop is sent all the same, and the page connects again by itself", async () => {
  const end = await watched();
  assert.ok(await page.locator("#lost").isHidden());
  run.away(true);
  try {
    await page.waitForSelector("#lost:not([hidden])");
    const sizes = await page.evaluate(() => [document.querySelector("#lost b"), document.getElementById("state")].map((e) => parseFloat(getComputedStyle(e).fontSize)));
    assert.ok(sizes[0] > sizes[1], "larger than the state");
    for (const width of [390, 768, 1400]) {
      await page.setViewportSize({ width, height: 900 });
      assert.deepEqual(await overlaps(), [], `at ${width} px`);
      await page.screenshot({ path: `${PICTURES}/alone_lost_${width}.png` });
    }
    await page.click("#stop");
    await until(() => run.stops > 0, "the stop", 5000);
    assert.deepEqual(run.calls, []);
  } finally {
    run.away(false);
  }
  await page.waitForSelector("#lost", { state: "hidden" });
  run.say("/task/status", status("hold", { t: 20 }), 20);
  await until(async () => (await page.textContent("#state")) === "hold", "the newest state");
  end();
});

test("all of it by keyboard: the scene turns, and every control can be reached", async () => {
  const end = await watched();
  const picture = () => page.evaluate(() => document.getElementById("scene").toDataURL());
  await page.focus("#scene");
  for (const key of ["ArrowLeft", "ArrowUp", "+", "3"]) {
    const before = await picture();
    await page.keyboard.press(key);
    await until(async () => (await picture()) !== before, `another picture after ${key}`, 5000);
  }
  const reached = new Set();
  await page.evaluate(() => document.activeElement.blur());
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("Tab");
    reached.add(await page.evaluate(() => document.activeElement.id));
  }
  for (const id of ["theme", "stop", "strip", "scene", "candidates", "log"]) assert.ok(reached.has(id), id);
  end();
});

test("a recording is paused, searched, stepped through and played at another speed", async () => {
  const lines = [];
  const line = (t, topic, message) => lines.push(`${topic} ${Math.round(1e9 * t)} ${JSON.stringify(message)}`);
  line(0, "/scene", scene(VERDICTS));
  line(0, "/task/change", { t: 0, state: "observe", because: "begin" });
  line(2, "/task/change", { t: 2, state: "lift", because: "ready" });
  line(6, "/task/change", { t: 6, state: "hold", because: "up" });
  for (let i = 0; i <= 80; ++i) {
    const t = i / 10;
    // as in a run, the status says so after the change
    line(t, "/task/status", status(t <= 2 ? "observe" : t <= 6 ? "lift" : "hold", { t }));
    line(t, "/load", load(t < 2 ? null : Math.min(0.05, 0.0125 * (t - 2)), { share: t < 2 ? null : 0.4 }));
  }
  line(1.5, "/task/intent", { t: 1.5, motion: "lift", in_s: 0.5, says: "the arm lifts the object" });
  lines.push("no line at all", "/load x {}", "/load 8000000001 {broken");
  const end = await watched({ name: "CoLift, recording a.mcap", documents: { ...robot, "/recording.txt": lines.join("\n") } });
  const press = (what) => page.click(`#replay [data-do=${what}]`);
  const state = () => page.textContent("#state");
  const raised = async () => Number(await page.evaluate(() => document.getElementById("scene").dataset.raisedMm));
  await press("play"); // the page plays by itself now, paused where the server was
  await until(async () => (await page.textContent("#replay output")) === "4.0 s of 8.0 s", "the place");
  run.say("/task/status", status("aborted"), 9); // what the server says is not shown meanwhile
  await press("forward");
  assert.equal(await state(), "hold");
  assert.equal(await page.isVisible("#intent"), false); // what was announced then is over
  await until(async () => Math.abs((await raised()) - 50) < 1, "the height at the end");
  await press("back");
  assert.equal(await state(), "lift");
  assert.deepEqual(await page.$$eval("#strip li:not(.to-come) b", (list) => list.map((b) => b.textContent)), ["observe", "lift"]);
  await press("begin");
  assert.equal(await state(), "observe");
  await page.locator("#replay input").fill("500");
  assert.equal(await page.textContent("#replay output"), "4.0 s of 8.0 s");
  await until(async () => Math.abs((await raised()) - 25) < 2, "the height in the middle");
  await page.screenshot({ path: `${PICTURES}/alone_replay.png` });
  await page.selectOption("#replay select", "8");
  await page.focus("#scene");
  await page.keyboard.press(" ");
  await until(async () => (await page.textContent("#replay output")) === "8.0 s of 8.0 s", "the end", 20000);
  assert.equal(await state(), "hold");
  // it lies behind what "8.0 s" is rounded from
  await until(async () => /a message of \/load is damaged/.test(await page.textContent("#log")), "the damaged message");
  await page.keyboard.press("Home");
  assert.equal(await state(), "observe");
  await page.click("#replay ol button:has-text('hold')");
  assert.equal(await state(), "hold");
  await press("live");
  await until(async () => (await state()) === "aborted", "what the server says", 20000);
  end();
});

test("two recordings are played side by side on one clock", async () => {
  const recording = (lift_s, height_m) => {
    const lines = [], line = (t, topic, message) => lines.push(`${topic} ${Math.round(1e9 * t)} ${JSON.stringify(message)}`);
    line(0, "/scene", scene(VERDICTS));
    [["observe", 0], ["lift", lift_s], ["hold", lift_s + 4]].forEach(([state, t]) => line(t, "/task/change", { t, state, because: "it is time" }));
    for (let i = 0; i <= 10 * (lift_s + 6); ++i) {
      const t = i / 10, risen = Math.min(1, Math.max(0, (t - lift_s) / 4));
      line(t, "/task/status", status(t < lift_s ? "observe" : t < lift_s + 4 ? "lift" : "hold", { t }));
      line(t, "/load", load(t < lift_s ? null : height_m * risen, { share: t < lift_s ? null : 0.4 }));
    }
    return lines.join("\n");
  };
  const end = await watched({ name: "CoLift, recording a.mcap", operates: false,
    documents: { ...robot, "/recording.txt": recording(2, 0.05), "/beside.txt": recording(3, 0.03) } });
  const both = await browser.newPage();
  both.on("pageerror", (error) => errors.push(error.message));
  await both.setViewportSize({ width: 1400, height: 800 });
  await both.goto(run.url);
  await until(async () => (await both.textContent("#link")) === "recording", "the recording's page");
  assert.equal(await both.isVisible("#stop"), false); // nothing to stop
  await both.goto(new URL("both.html", run.url).href);
  await until(async () => (await both.textContent("#time")) === "0.0 s", "both halves", 30000);
  assert.equal(await both.textContent("#state-a"), "lift, 2.0 s"); // time 0 is the begin of the lift in both
  assert.equal(await both.textContent("#state-b"), "lift, 3.0 s");
  const half = (name) => both.frames().find((frame) => frame.url().includes(`half=${name}.txt`));
  const raised = async (name) => Number(await half(name).evaluate(() => document.getElementById("scene").dataset.raisedMm));
  await both.locator("#place").fill("4");
  await until(async () => Math.abs((await raised("recording")) - 50) < 1 && Math.abs((await raised("beside")) - 30) < 1, "both heights", 30000);
  for (const name of ["recording", "beside"]) {
    assert.equal(await half(name).textContent("#state"), "hold");
    assert.equal(await half(name).isVisible("#stop"), false);
  }
  await both.screenshot({ path: `${PICTURES}/alone_both.png` });
  await both.evaluate(AXE);
  assert.deepEqual(await both.evaluate(async () => (await axe.run(document, { iframes: false })).violations.map((v) => v.id)), []);
  await both.selectOption("#zero", "");
  assert.equal(await both.textContent("#state-b"), "observe, 0.0 s");
  await both.selectOption("#speed", "8");
  await both.click("#play");
  // 8.95 s read "9.0 s" too: it is over when it can be played again
  await until(async () => (await both.textContent("#play")) === "Play", "the end of the longer one", 30000);
  assert.equal(await both.textContent("#time"), "9.0 s");
  assert.equal(await both.textContent("#state-a"), "hold, 8.0 s"); // the shorter one stays at its end
  await both.close();
  end();
});

test("a recording that the server does not hand out is said to be missing, and the page follows on", async () => {
  const end = await watched({ name: "CoLift, recording a.mcap" });
  await page.click("#replay [data-do=forward]");
  await until(async () => /cannot be played here/.test(await page.textContent("#log")), "the reason");
  assert.equal(await page.textContent("#state"), "lift");
  end();
});
