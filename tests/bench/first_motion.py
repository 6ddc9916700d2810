#!/usr/bin/env python3
"""From the person's grasp to the arm's first motion, and a whole lift's time: simulated lifts of the shipped scenarios.

    tests/bench/first_motion.py build/colift [--seeds 10] [--first 1]

Prints computing times (the dwell, in which the hand has to rest, is not counted) and the times real time as a table.
"""
import argparse
import json
import statistics
import subprocess
import sys

SCENARIOS = ("table", "box", "pipe", "chair")


def lift(colift, scenario, seed):
    """The timing of one run that planned a motion; None where it decided otherwise."""
    done = subprocess.run([colift, "run", "--scenario", scenario, "--seed", str(seed), "--json", "--quiet"],
                          capture_output=True, text=True)
    if done.returncode not in (0, 1):
        sys.exit(f"{scenario}, seed {seed}: {done.stderr.strip()}")
    run = json.loads(done.stdout)
    return run["timing"] if any(s["state"] == "approach" for s in run["states"]) else None


def at(values, part):
    return sorted(values)[min(len(values) - 1, int(part * len(values)))]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("colift")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=1)
    args = parser.parse_args()
    print("| scenario | lifts | decide ms, median | plan ms, median | together, median / 95 % / most | times real time |")
    print("| --- | ---: | ---: | ---: | ---: | ---: |")
    everything = []
    for scenario in SCENARIOS:
        found = [lift(args.colift, scenario, s) for s in range(args.first, args.first + args.seeds)]
        found = [t for t in found if t]
        both = [t["decision_compute_ms"] + t["plan_ms"] for t in found]
        everything += both
        print(f"| {scenario} | {len(found)} | {statistics.median(t['decision_compute_ms'] for t in found):.1f} "
              f"| {statistics.median(t['plan_ms'] for t in found):.1f} "
              f"| {statistics.median(both):.1f} / {at(both, 0.95):.1f} / {max(both):.1f} "
              f"| {statistics.median(t['sim_s'] / t['wall_s'] for t in found):.1f} |")
    print(f"\nOf all {len(everything)}: median {statistics.median(everything):.1f} ms, 95 % below {at(everything, 0.95):.1f} ms "
          "(goal 15 ms at 99 %).")


if __name__ == "__main__":
    main()
