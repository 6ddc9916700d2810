#!/usr/bin/env python3
"""The PC stands still while it commands the arm: SIGSTOP on `colift hal arm hold` for 5 ms to 2 s, at random instants,
against `colift emulate krc` in real time. Judged from outside: the controller saw no rule broken by the client but
missing answers (no step, no wrong first command), the client ended by itself, and where command mode was lost the
reason names this machine and for how long it stood still.

Standard library only. Usage: stall_campaign.py COLIFT [--trials N] [--seed S]; exit code 1 when a trial was judged wrong.
"""

import argparse
import json
import math
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time

HOLD_S = 3.0
LONGEST_S = 30.0  # until a client that does not end by itself is given up


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def trial(colift, rng, cycle_ms):
    port = free_port()
    with tempfile.TemporaryDirectory() as folder:
        robot = os.path.join(folder, "robot.yaml")
        with open(robot, "w") as f:
            f.write("arm: fri\nfri: {address: 127.0.0.1, port: %d, end_script: true}\n" % port)
        krc = subprocess.Popen([colift, "emulate", "krc", "--plant", "light", "--to", "127.0.0.1:%d" % port, "--cycle-ms",
                                str(cycle_ms), "--linger-s", "0.5", "--for", "25", "--json"],
                               stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        client = subprocess.Popen([colift, "hal", "arm", "hold", "--robot", robot, "--for", str(HOLD_S), "--json"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        stop_s = math.exp(rng.uniform(math.log(0.005), math.log(2.0)))
        time.sleep(rng.uniform(0.1, HOLD_S + 1.0))
        began = time.monotonic()
        client.send_signal(signal.SIGSTOP)
        time.sleep(stop_s)
        client.send_signal(signal.SIGCONT)
        stood_s = time.monotonic() - began
        try:
            out, err = client.communicate(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            client.kill()
            client.communicate()
            krc.kill()
            krc.communicate()
            return stood_s, None, "the client did not end", "", False
        krc.send_signal(signal.SIGINT)
        try:
            said, _ = krc.communicate(timeout=LONGEST_S)
        except subprocess.TimeoutExpired:
            krc.kill()
            krc.communicate()
            return stood_s, client.returncode, "the controller did not end", err, False
        report = json.loads(said)
        why = ""
        # answers that are missing are the stall itself; everything else is the client's own doing
        broken = [r for r in report["broken_rules"] if r["rule"] != "missed-answers"]
        if client.returncode < 0:
            why = "the client died of signal %d" % -client.returncode
        elif broken:
            why = "the controller: %s" % "; ".join("%s: %s" % (r["rule"], r["because"]) for r in broken)
        elif client.returncode not in (0, 3):
            why = "exit code %d" % client.returncode
        named = re.search(r"did not run for ([0-9.]+) (m?)s", out + err)
        if not why and client.returncode == 3:
            if not named:
                why = "the stall is not named: " + (out + err).strip()[-300:]
            else:
                told_s = float(named.group(1)) * (1e-3 if named.group(2) else 1.0)
                if not 0.7 * stood_s - 0.02 <= told_s <= 1.5 * stood_s + 0.1:
                    why = "%.3f s are named" % told_s
        return stood_s, client.returncode, why, err, bool(named)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    rng = random.Random(options.seed)
    wrong = survived = named = 0
    longest_survived = 0.0
    for i in range(options.trials):
        cycle_ms = rng.choice([2, 5, 10])
        stood_s, code, why, err, told = trial(options.colift, rng, cycle_ms)
        survived += code == 0
        named += told
        if code == 0:
            longest_survived = max(longest_survived, stood_s)
        wrong += bool(why)
        print("%3d: %7.1f ms at %2d ms cycles: exit code %s%s" %
              (i + 1, 1e3 * stood_s, cycle_ms, code, ", WRONG: " + why if why else ", named" if told else ""), flush=True)
    print("%d trials: %d held on (the longest stall of them %.0f ms), %d ended; %d named their stall; %d wrong" %
          (options.trials, survived, 1e3 * longest_survived, options.trials - survived, named, wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
