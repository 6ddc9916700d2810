#!/usr/bin/env python3
"""Whole lifts over all three real drivers in real time, one for each seed, and whose fault each missed answer is.

Beside every lift `standstill` watches the processors, and `cyclictest` where it is installed (Debian: rt-tests). A miss
is the machine's own when its processors did not run together for 0.3 ms of the cycle (tests/support/standstill.py).
Means something only on a machine with nothing else to do. Half a minute a lift.

  real_time_lifts.py COLIFT [--lifts 20] [--cpu -1|N] [--scenarios table,pipe] [--both-controls] [--json FILE]
Exit: 0 all lifted and no miss is the program's; 1 not; 2 no witness.
"""

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "support"))
import emulated_robot  # noqa: E402
import standstill  # noqa: E402


class Cyclictest:
    """Its worst latency over the time of a `with`, in milliseconds; None where it is not installed."""

    def __enter__(self):
        self.worst_ms, program = None, shutil.which("cyclictest")
        self.child = program and subprocess.Popen([program, "-q", "-m", "-p", "90", "-S", "-i", "1000"],
                                                  stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        return self

    def __exit__(self, *_):
        if self.child:
            self.child.send_signal(signal.SIGINT)
            said, _ = self.child.communicate(timeout=30)
            worst = [int(n) for n in re.findall(r"Max:\s*(\d+)", said)]
            self.worst_ms = 1e-3 * max(worst) if worst else None


CONTROLS = ("joint_impedance", "cartesian_impedance")


def lift(colift, robot, seed, scenario, control):
    with standstill.Witness(standstill.beside(colift)) as witness, Cyclictest() as cyclictest:
        done = subprocess.run([colift, "run", "--robot", robot, "--seed", str(seed), "--scenario", scenario, "--set",
                               "task.lift.control=" + control, "--json", "--quiet"],
                              stdout=subprocess.PIPE, text=True)
    document = json.loads(done.stdout) if done.stdout.strip() else None
    return document, witness, cyclictest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("--lifts", type=int, default=20)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--cpu", type=int, default=-1)
    parser.add_argument("--scenarios", default="table", help="one after the other (default: table)")
    parser.add_argument("--both-controls", action="store_true",
                        help="every other lift with the impedance of the palm instead of the joints'")
    parser.add_argument("--json", metavar="FILE")
    options = parser.parse_args()
    if standstill.beside(options.colift) is None:
        print("no standstill beside colift: cmake -DCOLIFT_BENCH=ON, ninja standstill", file=sys.stderr)
        return 2
    print(f"{'seed':>4} {'':8}{'cycles':>8}{'p50':>6}{'p99':>6}{'worst':>7}{'missed':>8}{'own':>5}{'slow':>6}{'own':>5}"
          f"{'late cycles':>13}{'stood still':>13}{'cyclictest':>12}\n{'':>20}{'answer (us)':>19}{'':>24}"
          f"{'of the emulator':>19}{'worst (ms)':>15}", flush=True)
    rows = []
    scenarios = options.scenarios.split(",")
    with tempfile.TemporaryDirectory(prefix="colift-lifts-") as folder:
        robot = emulated_robot.write(folder, options.cpu)
        for seed in range(options.first_seed, options.first_seed + options.lifts):
            n = seed - options.first_seed
            control = CONTROLS[n % 2 if options.both_controls else 0]
            scenario = scenarios[n // (2 if options.both_controls else 1) % len(scenarios)]
            document, witness, cyclictest = lift(options.colift, robot, seed, scenario, control)
            if document is None or not document.get("arm_link"):
                rows.append({"seed": seed, "control": control, "scenario": scenario, "outcome": "none", "cycles": 0, "missed": 0, "missed_own": 0, "slow": 0,
                             "slow_own": 0})
                print(f"{seed:>4} failed: {document and document['because']}", flush=True)
                continue
            link = document["arm_link"]
            row = {"seed": seed, "control": control, "scenario": scenario, "outcome": document["outcome"], "because": document["because"],
                   "cycles": link["cycles"], "answer_us": link["answer_us"],
                   "missed": link["controller"]["missed_in_command"],
                   "missed_own": len(standstill.programs_own(standstill.missed(document), witness.stood)),
                   "slow": len(standstill.slow(document)),
                   "slow_own": len(standstill.programs_own(standstill.slow(document), witness.stood)),
                   "late_cycles": link["controller"]["late_cycles"], "stood_worst_ms": witness.worst_ms,
                   "cyclictest_worst_ms": cyclictest.worst_ms}
            rows.append(row)
            beside = "-" if cyclictest.worst_ms is None else f"{cyclictest.worst_ms:.1f}"
            print(f"{seed:>4} {row['outcome']:8}{row['cycles']:>8}{link['answer_us']['p50']:>6}{link['answer_us']['p99']:>6}"
                  f"{link['answer_us']['worst']:>7}{row['missed']:>8}{row['missed_own']:>5}{row['slow']:>6}"
                  f"{row['slow_own']:>5}{row['late_cycles']:>13}{witness.worst_ms or float('nan'):>13.1f}{beside:>12}"
                  + (f"  {scenario}, {control}" if options.both_controls else "")
                  + ("" if row["outcome"] == "lifted" else f"  {document['because']}"), flush=True)
    lifted = sum(r["outcome"] == "lifted" for r in rows)
    total = {k: sum(r[k] for r in rows) for k in ("cycles", "missed", "missed_own", "slow", "slow_own")}
    print(f"{lifted} of {len(rows)} lifted; {total['missed']} answers missed in {total['cycles']} cycles, "
          f"{total['missed_own']} of them the program's own; {total['slow']} slower than a cycle, {total['slow_own']} own")
    if options.both_controls:
        for control in CONTROLS:
            these = [r for r in rows if r["control"] == control]
            print(f"{control}: {sum(r['outcome'] == 'lifted' for r in these)} of {len(these)} lifted")
    if options.json:
        with open(options.json, "w") as f:
            json.dump({"cpu": options.cpu, "lifts": rows}, f, indent=1)
    return 0 if lifted == len(rows) and total["missed_own"] == 0 else 1


if __name__ == "__main__":
    sys.exit(main())
