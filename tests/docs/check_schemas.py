#!/usr/bin/env python3
"""Documents that the program prints are what `colift schema` publishes, key by key.

    tests/docs/check_schemas.py PROGRAM ROOT [SCHEMAS]

Carries commands out on inputs of the repository and on emulated devices, and validates each document against the program's own schema,
made strict: a key that the schema does not name fails too, though a reader has to expect new keys. Files that it reads likewise. Also
each schema against the meta-schema, and documents with a wrong value or a missing key, which have to fail; of a file the program has
to refuse the same. SCHEMAS: a folder, config/schema, whose files count instead of those compiled in. Ends with 0 when all agree,
1 with what does not, 77 (skipped) without Debian's python3-jsonschema and python3-yaml.
"""

import concurrent.futures
import json
import pathlib
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leaves nothing in the source tree
try:
    import jsonschema

    import schema_devices
    import schema_files
    from schema_checker import Checker
except ImportError as missing:
    print(f"skipped: there is no {missing.name} (tools/setup --dev installs python3-jsonschema and python3-yaml)")
    sys.exit(77)

PROBLEM = {"cog": [0, 0, 0], "partner": [-0.4, 0, 0], "candidates": [[0.4, 0, 0], [0.2, 0, 0]], "wrenches": [[0, 0, 40, 0, 0, 0]],
           "weights": {"epsilon": 1, "omega1": 1, "omega2": 1}}
TIGHT = dict(PROBLEM, limits={"partner": {"force": 1, "torque": 0.1}, "robot": {"force": 1}})


def recordings(c, folder):
    """The verbs of log: on two runs, on one that was cut, on a run that is going on."""
    a, b, cut = (folder / f"{name}.mcap" for name in ("a", "b", "cut"))
    c.run("run", "--seed", "1", "--dry-run", "--quiet", "--record", a)
    c.run("run", "--seed", "2", "--dry-run", "--quiet", "--record", b, "--share", "0.3")
    cut.write_bytes(a.read_bytes()[: a.stat().st_size // 2])
    for file in (a, cut):
        c.command("log-info", "log", "info", file)
    c.command("log-recover", "log", "recover", cut, "--out", folder / "whole.mcap")
    formats = ["csv", "png"] + ["ros2"] * ("without Cyclone DDS" not in c.run("log", "export", a, "--format", "ros2", "--out", folder / "bag").stderr)
    exported = c.command("log-export", "log", "export", cut, "--out", folder / "out", *(w for f in formats for w in ("--format", f)))
    compared = c.command("log-compare", "log", "compare", a, b)
    c.command("log-compare", "log", "compare", a, cut)
    replayed = c.command("log-replay", "log", "replay", a)
    other = c.command("log-replay", "log", "replay", a, "--set", "decision.weights.epsilon=3")
    c.command("log-replay", "log", "replay", cut)
    if replayed and other and not (replayed["same"] and other["differences"]):
        c.wrong.append("a replay with another configuration shows no difference, or one with the same does")
    snapshot(c, folder / "snapshot.mcap")
    if compared:
        c.has_to_fail("log-compare", compared, lambda d: d["curves"].update(aligned="nowhere"), "curves that are aligned nowhere")
    if exported:
        c.has_to_fail("log-export", exported, lambda d: d["exports"][0].update(format="bag"), "a format that does not exist")
    if replayed:
        c.has_to_fail("log-replay", replayed, lambda d: d.update(same=None), "a replay that says nothing of its result")
        c.has_to_fail("log-replay", replayed, lambda d: d.pop("cycles"), "a replay without its cycles")


def snapshot(c, file):
    """Asks a run that goes on in real time for its last seconds; it is stopped then."""
    run = subprocess.Popen([c.program, "run", "--seed", "1", "--view", "0", "--speed", "1", "--quiet", "--flight", str(file) + ".fault"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        deadline = time.monotonic() + 120
        while True:  # it may not be ready to be asked yet
            done = c.run("log", "snapshot", file, "--pid", run.pid, "--json", "--quiet")
            if done.returncode == 0:
                c.validate("log-snapshot", json.loads(done.stdout), "colift log snapshot")
                return
            if run.poll() is not None or time.monotonic() > deadline:
                c.wrong.append("a run did not give its last seconds: " + done.stderr[-200:])
                return
    finally:
        run.kill()
        run.wait()


def devices(c, root):
    """All that waits for devices, side by side: they are emulated in real time."""
    with tempfile.TemporaryDirectory() as name, concurrent.futures.ThreadPoolExecutor(4) as pool:
        folder = pathlib.Path(name)
        arm, camera = pool.submit(schema_devices.arm, c, folder), pool.submit(schema_devices.camera, c, folder)
        hand = pool.submit(schema_devices.hand, c, folder)
        rest = pool.submit(lambda: (schema_devices.recovery(c), schema_files.robots(c, folder, root)))
        calibrations(c, folder)
        schema_files.scenarios(c, folder, root)
        schema_files.rigs(c, folder, root)
        for done in (arm, camera, rest):
            done.result()
        schema_files.hand_calibrations(c, folder, hand.result())


def calibrations(c, folder):
    """Accepted and refused."""
    few = ("calibrate", "--sim", "--seed", "1", "--out", folder / "camera.yaml")
    good = c.command("calibrate", *few, "--poses", "8", "--set", "calibration.min_inliers=8")
    c.command("calibrate", *few, "--poses", "5")
    if good:
        c.has_to_fail("calibrate", good, lambda d: d.update(refused="bad-luck"), "a refusal that does not exist")
        c.has_to_fail("calibrate", good, lambda d: d["camera"]["position"].pop(), "a camera at two numbers")
        c.has_to_fail("calibrate", good, lambda d: d.pop("poses"), "a calibration without its poses")
        if not good["accepted"]:
            c.wrong.append("a simulated calibration of eight poses was refused: " + good["because"])


def main():
    program, root = sys.argv[1], pathlib.Path(sys.argv[2])
    c = Checker(program, pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None)
    names = json.loads(c.run("schema", "--json").stdout)
    shipped = sorted(p.stem for p in (root / "config/schema").glob("*.json"))
    if c.schemas:
        names = shipped
    if sorted(names) != shipped:
        c.wrong.append(f"colift schema names {names}; config/schema has others")
    for name in names:
        jsonschema.Draft202012Validator.check_schema(c.schema(name))
    if c.run("schema", "rnu").returncode != 2:
        c.wrong.append("a schema that is not there is no error")

    real, scenarios = root / "tests/data/real", root / "config/scenario"
    for folder in sorted(real.iterdir()):
        if (folder / "depth.png").exists():
            c.command("look", "look", folder / "depth.png")
    c.command("decide", "decide", real / "01_office_chair_and_bottles/depth.png", "--partner=-0.45,-0.5,1.75", "--share", "0.3")
    c.command("decide", "decide", real / "04_five_people/depth.png", "--partner=0,0,2")
    c.command("scenes", "scene", root / "tests/data/scenes", "--method", "both")
    run = c.command("run", "run", "--seed", "3")
    c.command("run", "run", "--seed", "3", "--dry-run")
    for name in ("no_partner", "wrong_cog", "person_in_the_path", "partner_lets_go"):
        c.command("run", "run", "--scenario", scenarios / f"{name}.yaml", "--seed", "3", "--set", "task.partner_timeout_s=5")
    c.command("check", "check")
    rules = c.command("rules", "check", "--graph")
    if rules:
        c.has_to_fail("rules", rules, lambda r: r["states"].clear(), "a job without states")
        c.has_to_fail("rules", rules, lambda r: r["rules"][0].pop("on"), "a rule without its event")
    for kind in ("scenarios", "robots", "scenes"):
        listed = c.command("shipped", kind)
        names_there = {"scenarios": [f.stem for f in scenarios.glob("*.yaml")], "robots": [f.stem for f in (root / "config").glob("*.yaml")],
                       "scenes": [f.parent.name for f in real.glob("*/depth.png")]}[kind]
        if listed and [f["name"] for f in listed["files"]] != sorted(names_there):
            c.wrong.append(f"colift {kind} lists others than the folder has")
        c.wrong += [f"{f['file']} does not say what it is for" for f in (listed or {"files": []})["files"] if not f["about"]]
    c.command("doctor", "doctor")
    with tempfile.TemporaryDirectory() as folder:
        for problem in (PROBLEM, TIGHT):
            file = pathlib.Path(folder) / "problem.json"
            file.write_text(json.dumps(problem))
            c.validate("rank-problem", problem, "a problem of rank")
            c.command("rank", "rank", file)
        c.command("experiment", "experiment", "grasps", "--trials", "1", "--out", folder)
        recordings(c, pathlib.Path(folder))
    devices(c, root)

    if run:
        c.has_to_fail("run", run, lambda r: r.update(outcome="carried"), "an outcome that does not exist")
        c.has_to_fail("run", run, lambda r: r.pop("judge"), "a run without judge")
        c.has_to_fail("run", run, lambda r: r["lift"].update(share_robot="half"), "a share in words")
        c.has_to_fail("run", run, lambda r: r["decision"]["position"].pop(), "a position of two numbers")
    c.has_to_fail("rank-problem", PROBLEM, lambda p: p["weights"].update(epsilon=0), "epsilon = 0")
    c.has_to_fail("rank-problem", PROBLEM, lambda p: p.update(candidates=[]), "a problem without candidates")
    c.wrong += [f"no document was checked against the schema {name}" for name in set(names) - {name for name, _ in c.agreed}]
    print("\n".join(c.wrong) or f"{len(c.agreed)} documents agree with {len(names)} schemas")
    return 1 if c.wrong else 0


if __name__ == "__main__":
    sys.exit(main())
