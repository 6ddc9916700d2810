// A simulated lift with its live view, as a user would start it.
import { spawn } from "node:child_process";

export const PROGRAM = process.env.COLIFT_PROGRAM ?? "build/colift";

/** The file of a shipped scenario. */
export const scenario = (name) => `${process.env.COLIFT_SCENARIOS ?? "config/scenario"}/${name}.yaml`;

/** Starts `colift run --view 0 ...`; `url` is what it printed. */
export const startLift = (...more) => startView("run", "--view", "0", "--seed", "1", "--quiet", ...more);

/** Starts a command with a live view. */
export async function startView(...command) {
  const child = spawn(PROGRAM, command, { stdio: ["ignore", "pipe", "pipe"] });
  const lift = { child, errors: "", output: "", exit: new Promise((done) => child.on("exit", (code) => done(code))) };
  child.stdout.on("data", (data) => { lift.output += data; });
  lift.url = await new Promise((found, failed) => {
    child.stderr.on("data", (data) => {
      lift.errors += data;
      const url = /live view: (\S+)/.exec(lift.errors);
      if (url) found(url[1]);
    });
    child.on("exit", (code) => failed(new Error(`colift ended with ${code}: ${lift.errors}`)));
  });
  lift.end = async () => {
    child.kill("SIGINT");
    return lift.exit;
  };
  return lift;
}

/** Waits until `ready` returns something, and returns it. */
export async function until(ready, what, ms = 60000) {
  const deadline = Date.now() + ms;
  for (;;) {
    const value = await ready();
    if (value) return value;
    if (Date.now() > deadline) throw new Error(`waited ${ms} ms for ${what}`);
    await new Promise((next) => setTimeout(next, 50));
  }
}
