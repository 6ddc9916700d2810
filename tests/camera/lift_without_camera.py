#!/usr/bin/env python3
"""Whole lifts over all three real drivers whose camera is lost: its capture process killed or stopped, or the cable
pulled, in each phase. In real time; the far ends are emulated in the program itself.

    lift_without_camera.py COLIFT [--all] [--list] [CASE...]

A CASE is FAULT:PHASE, as kill:lift; without any: kill:lift, with --all or COLIFT_THOROUGH in the environment all of
them (half a minute each). The reactions are those of docs/task.md, and the arm's cycle may miss nothing for it: no
answer but those for which the machine stood still (tests/support/standstill.py; without that witness, where benchmarks
are not built, misses are told and not judged). Prints a line for each run, exit code 1 if one
fails, 77 if the machine had no time for the arm's cycle.
"""

import argparse
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import standstill  # noqa: E402

FAULTS = ("kill", "stop", "unplug")
PHASES = ("observe", "await-partner", "decide", "plan", "approach", "close", "verify", "await-ready", "lift", "hold",
          "lower", "release", "retreat")
LOADED = ("await-ready", "lift", "hold", "lower", "release", "retreat")  # the camera is not needed any more
UNPLUGGED_S = 2.0
TRIES = 3  # where the machine had no time
TOO_LATE_MS = 20.0  # of the emulated controller, whose cycle is 2 ms: then nothing is said about the program
PATIENCE_S = 150.0  # for a run: a slow machine makes it slower, not wrong
# Driver and emulated controller share a processor, as in config/emulated.yaml: one that stands still stops both. What the
# driver is late by for another reason shows in its own times then.
CPU = 1 if (os.cpu_count() or 1) > 1 else 0
TABLE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../config/scenario/table.yaml")
LINE = re.compile(r"^\s*([0-9.]+) s  ([a-z-]+)")


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Folder:
    """Files of one run, gone at the end."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory(prefix="colift-camera-")

    def write(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w") as f:
            f.write(text)
        return path

    def robot(self):
        return self.write("robot.yaml", f"""arm: fri
hand: barrett
camera: kinect
emulator: always
fri: {{address: 127.0.0.1, krc: 127.0.0.1, port: {free_port(socket.SOCK_DGRAM)}, cycle_ms: 2, script: colift, cpu: {CPU}}}
barrett: {{can: "socketcand:127.0.0.1:{free_port(socket.SOCK_STREAM)}/can0"}}
kinect: {{source: "emulated:@colift-camera-{os.getpid()}", motor: true, latency_ms: 10}}
""")

    def scenario(self, unplug_at_s, phase):
        """The usual table, and the cable pulled at a time."""
        # who comes before the scene was seen without him is no change of it
        later = "arrives_s: 7.0" if phase == "observe" else r"\g<0>"
        faults = "" if unplug_at_s is None else (
            f"faults:\n  - {{at_s: {unplug_at_s:.2f}, device: camera, do: unplug, for_s: {UNPLUGGED_S}}}\n")
        with open(TABLE) as f:
            return self.write("scenario.yaml", re.sub(r"arrives_s: [0-9.]+", later, f.read()) + faults)


def capture_process(of):
    """Process number of the camera's process that a program has started."""
    for name in os.listdir("/proc"):
        if not name.isdigit():
            continue
        try:
            with open(f"/proc/{name}/stat") as f:
                stat = f.read()
        except OSError:
            continue
        command = stat[stat.index("(") + 1:stat.rindex(")")]
        state, parent = stat[stat.rindex(")") + 2:].split()[:2]
        if command == "colift-kinect" and int(parent) == of and state != "Z":
            return int(name)
    return None


def run(colift, fault=None, phase=None, unplug_at_s=None):
    """One whole run. Its document, its exit code, when the fault came (by the run's clock), who watched the machine."""
    files = Folder()
    witness = standstill.Witness(standstill.beside(colift))
    call = [colift, "run", "--robot", files.robot(), "--scenario", files.scenario(unplug_at_s, phase), "--json", "--seed", "1"]
    with tempfile.TemporaryFile("w+") as out, witness:
        # what the flight recorder keeps goes with the run's files
        child = subprocess.Popen(call, stdout=out, stderr=subprocess.PIPE, text=True,
                                 env={**os.environ, "XDG_STATE_HOME": files.folder.name})
        at, said = None, []
        began = time.monotonic()
        for line in child.stderr:
            said.append(line.rstrip())
            seen = LINE.match(line)
            if seen and seen[2] == phase and at is None and fault in ("kill", "stop"):
                victim = capture_process(child.pid)
                if victim is not None:
                    os.kill(victim, signal.SIGKILL if fault == "kill" else signal.SIGSTOP)
                    at = float(seen[1])
            if time.monotonic() - began > PATIENCE_S:
                child.kill()
        child.wait()
        out.seek(0)
        text = out.read()
    # a run that could not begin has no document: what it said instead
    document = json.loads(text) if text.strip() else {"states": [], "faults": [{"device": "rig", "what": said[-1:]}],
                                                      "because": said[-1:], "arm_link": None}
    return document, child.returncode, at, witness


def states_of(document):
    return [(s["t"], s["state"]) for s in document["states"]]


def state_at(document, t):
    now = None
    for since, state in states_of(document):
        if since <= t:
            now = state
    return now


def stood(document):
    """What was said of arm and hand beyond the pace: that one was lost, or stood."""
    return [f for f in document["faults"]
            if f["device"] != "camera" and "reduced speed" not in f["what"] and "full speed" not in f["what"]]


def machine_had_no_time(document):
    """One of them stood, and the far end of the arm's wire, in the same program, had not run for so long either; or
    others keep this machine busy."""
    link = document["arm_link"]
    late = link is not None and link["controller"]["worst_late_ms"] > TOO_LATE_MS
    return bool(stood(document)) and (late or os.getloadavg()[0] > 2 * (os.cpu_count() or 1))


def spans_of(document):
    return standstill.missed(document) + standstill.slow(document)


def own_of(document, witness):
    """Those of the program, and when a processor stood meanwhile, in ms from their beginnings."""
    own = standstill.programs_own(spans_of(document), witness.stood)
    return [(1e3 * (b - a), [(1e3 * (c - a), 1e3 * (d - a)) for c, d in witness.stood or [] if d > a and c < b])
            for a, b in own]


def missed(document, witness):
    """Answers missed in command or slower than a cycle, and those of them that are the program's own (None: nobody can
    tell)."""
    spans = spans_of(document)
    return len(spans), None if witness.stood is None else len(standstill.programs_own(spans, witness.stood))


def check(document, code, fault, witness):
    """The reactions of docs/task.md, from what the run says of itself. What was checked, in words."""
    camera = [f for f in document["faults"] if f["device"] == "camera"]
    lost = next((f for f in camera if f["what"] != "is back"), None)
    assert lost, f"nobody noticed that the camera was gone: {document['because']}; {states_of(document)}"
    back = next((f for f in camera if f["what"] == "is back" and f["t"] > lost["t"]), None)
    if fault == "kill":
        assert "signal 9" in lost["what"] or "no frame" in lost["what"], lost
    where = state_at(document, lost["t"] - 1e-6)
    all_states = states_of(document)
    after = [s for t, s in all_states if t >= lost["t"] - 1e-6]
    arm = document["arm_link"]["controller"]
    assert arm["broken_rules"] == [], arm
    assert not missed(document, witness)[1], f"the arm's cycle missed answers: {own_of(document, witness)}"
    assert not stood(document), f"arm or hand were disturbed: {stood(document)}"
    if where in LOADED:
        assert "halt" not in after and document["outcome"] == "lifted", (where, after, document["because"])
        slow = [f for f in document["faults"] if f["device"] == "arm" and "continues at reduced speed" in f["what"]]
        if where in ("lift", "lower"):
            assert slow, f"the arm did not slow down: {document['faults']}"
    elif where in ("approach", "back-off"):
        # after 0.15 s without a picture the partner counts as gone already, and the arm brakes for that
        halted = next((t for t, s in all_states if s == "halt" and t >= lost["t"] - 1e-6), None)
        assert halted is not None and halted - lost["t"] < 0.1, (halted, lost, all_states)
        assert back and document["outcome"] == "lifted", (document["outcome"], document["because"])
    elif where in ("close", "verify"):
        # a silent camera counts as a partner who let go: opens, goes home, tries again or ends there
        assert document["outcome"] in ("lifted", "aborted"), document["outcome"]
    else:
        first = next((t for t, s in all_states if s == "approach" and t > lost["t"]), None)
        assert back and (first is None or first > back["t"]), "moved before the camera was back"
        assert document["outcome"] == "lifted", (document["outcome"], document["because"])
    assert not document["hand_keeps_grip"], document["because"]
    assert code == (0 if document["outcome"] == "lifted" else 1), code
    return where, lost["t"], back["t"] - lost["t"] if back else None


def line_of(document, witness, where, lost_t, gone_s):
    in_command, own = missed(document, witness)
    whose = "" if own is None else f", {own} of them its own, {in_command - own} the machine's"
    link, arm = document["arm_link"], document["arm_link"]["controller"]
    gone = "not back" if gone_s is None else f"back after {gone_s:.1f} s"
    return (f"noticed in {where} at {lost_t:.2f} s, {gone}; {document['outcome']}; cycles {arm['sent']}, answers missed "
            f"in command or late {in_command}{whose}; controller's own late cycles "
            f"{arm['late_cycles']} (worst {arm['worst_late_ms']:.1f} ms); answers p99 {link['answer_us']['p99']:.0f} us")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("cases", nargs="*")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--list", action="store_true")
    options = parser.parse_args()
    every = [f"{fault}:{phase}" for phase in PHASES for fault in FAULTS]
    if options.list:
        print("\n".join(every))
        return 0
    thorough = options.all or "COLIFT_THOROUGH" in os.environ
    cases = options.cases or (every if thorough else ["kill:lift"])
    unknown = [c for c in cases if c not in every]
    if unknown:
        parser.error(f"no case: {', '.join(unknown)}; see --list")

    failed = no_time = 0
    usual = None
    if any(c.startswith("unplug") for c in cases):
        # when each phase comes, for faults that are told beforehand
        for _ in range(TRIES):
            usual, code, _, witness = run(options.colift)
            if not stood(usual):
                break
        if stood(usual):
            print(f"undisturbed: {stood(usual)[0]['what']}")
            return 77 if machine_had_no_time(usual) else 1
        print(f"undisturbed: {usual['outcome']}, exit code {code}, answers missed in "
              f"command or late {missed(usual, witness)[0]}", flush=True)
    for case in cases:
        fault, phase = case.split(":")
        unplug_at_s = None
        if fault == "unplug":
            times = states_of(usual)
            began = next((t for t, s in times if s == phase), None)
            if began is None:
                print(f"{case}: not reached without any fault")
                failed += 1
                continue
            unplug_at_s = max(0.1, began + 0.05)
        try:
            for _ in range(TRIES):
                document, code, at, witness = run(options.colift, fault, phase, unplug_at_s)
                if not stood(document):
                    break
            if machine_had_no_time(document):
                no_time += 1
                print(f"{case}: the machine has no time (load {os.getloadavg()[0]:.0f}): {stood(document)[0]['what']}",
                      flush=True)
                continue
            assert fault == "unplug" or at is not None, f"never came to {phase}: {states_of(document)}"
            print(f"{case}: {line_of(document, witness, *check(document, code, fault, witness))}", flush=True)
        except AssertionError as error:
            failed += 1
            print(f"{case}: FAILED: {error}", flush=True)
    return 1 if failed else 77 if no_time else 0


if __name__ == "__main__":
    sys.exit(main())
