"""Tells a late answer of the program from one for which the machine stood still. `build/standstill` watches every
processor with the highest priority that there is; a run's document says when an answer was missed or slow, by the same
clock. An answer is the machine's fault when in all the time that it had the processors never ran together for
ENOUGH_S: a driver answers within 0.1 ms in 999 of 1000 cycles, and three threads have to run for it in turn.
"""

import json
import os
import signal
import subprocess

ENOUGH_S = 0.0003
SEEN_FROM_S = 0.0002  # the witness sleeps for so long: a processor may have stood before


class Witness:
    """`with Witness(program) as w: ...`; afterwards `w.stood`, spans in which some processor stood. Without the
    program, or where it is not granted its priority, `stood` is None: nothing can be told apart."""

    def __init__(self, program):
        self.program, self.stood, self.worst_ms = program, None, None

    def __enter__(self):
        self.child = subprocess.Popen([self.program], stdout=subprocess.PIPE, text=True) if self.program else None
        return self

    def __exit__(self, *_):
        if self.child is None:
            return
        self.child.send_signal(signal.SIGINT)
        said, _ = self.child.communicate(timeout=30)
        if self.child.returncode == 0:
            cpus = json.loads(said)["cpus"]
            self.stood = sorted((a - SEEN_FROM_S, b) for c in cpus for a, b in c["stood_monotonic_s"])
            self.worst_ms = 1e3 * max(c["worst_s"] for c in cpus)


def beside(colift):
    """The witness next to a colift program; None where it was not built (-DCOLIFT_BENCH=ON builds it)."""
    path = os.path.join(os.path.dirname(os.path.abspath(colift)), "standstill")
    return path if os.access(path, os.X_OK) else None


def ran_for(stood, start, end):
    """The longest time between `start` and `end` in which no processor stood (s)."""
    longest, at = 0.0, start
    for a, b in stood:
        if b <= at:
            continue
        if a >= end:
            break
        longest, at = max(longest, a - at), max(at, b)
    return max(longest, end - at, 0.0)


def programs_own(spans, stood):
    """Those for which the machine is no excuse."""
    return [s for s in spans if stood is None or ran_for(stood, *s) >= ENOUGH_S]


def missed(document):
    """Answers missed while the emulated controller took commands: (from, until) of each."""
    return document["arm_link"]["controller"]["missed_monotonic_s"]


def slow(document):
    """Answers that took the driver longer than a cycle: (arrived, answered) of each."""
    return document["arm_link"]["slow_monotonic_s"]
