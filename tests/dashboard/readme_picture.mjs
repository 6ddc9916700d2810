// The picture of the page in the README, from a lift that is recorded and then played to the end of its hold.
//   node readme_picture.mjs PROGRAM PICTURE.png     (in a folder with this folder's files, after npm ci)
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { launchBrowser } from "./browser.mjs";

const [program, picture] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), "colift-"));
const recording = join(folder, "lift.mcap");
execFileSync(program, ["run", "--scenario", "table", "--seed", "1", "--record", recording, "--quiet"], { stdio: "inherit" });
const replay = spawn(program, ["log", "replay", recording, "--view", "0", "--quiet"], { stdio: ["ignore", "ignore", "pipe"] });
const url = await new Promise((found) => {
  let said = "";
  replay.stderr.on("data", (bytes) => {
    const address = /live view: (\S+)/.exec((said += bytes));
    if (address) found(address[1]);
  });
});
const browser = await launchBrowser();
try {
  const page = await browser.newPage({ viewport: { width: 1366, height: 768 }, colorScheme: "light" });
  await page.goto(url);
  await page.waitForSelector("#replay:not([hidden])");
  await page.click("#replay [data-do=play]");
  await page.click("#replay ol button:has-text('lower')");
  const at = () => page.evaluate(() => {
    const { touches, drawn } = document.getElementById("scene").dataset;
    return { state: document.getElementById("state").textContent, drawn: Number(drawn) >= Number(touches) };
  });
  // the page has to get the recording before it can go anywhere in it
  const until = Date.now() + 120_000;
  for (let still = 0; still < 10; await new Promise((later) => setTimeout(later, 500))) {
    if (Date.now() > until) throw new Error(`the page did not come to rest in two minutes: ${JSON.stringify(await at())}`);
    const { state, drawn } = await at();
    if (state !== "lower") await page.click("#replay ol button:has-text('lower')");
    still = state === "lower" && drawn ? still + 1 : 0;
  }
  await page.screenshot({ path: picture });
} finally {
  await browser.close();
  replay.kill();
  rmSync(folder, { recursive: true });
}
