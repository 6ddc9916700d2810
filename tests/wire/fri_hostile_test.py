#!/usr/bin/env python3
"""Drives `colift hal arm` as a KRC that lies, counts anew or is loaded, and ends it as a terminal does that goes away:
what it commands meanwhile is judged at the far end of the wire.

Standard library only, and nothing of CoLift's own code. Usage: fri_hostile_test.py COLIFT [NAME...]
"""

import math
import re
import signal
import struct
import sys
import time

from fri_server import CMD, MON, PERIOD, Krc, single
from wire_tests import main

# the data sheet's limits of the joints
VELOCITY = [math.radians(v) for v in (110, 110, 128, 128, 204, 184, 184)]
ACCELERATION = 15.0  # documented: what the driver and its guard stop with
ROUNDING = 1e-6  # of the sum of two singles
MANY = 5000  # cycles: more than any motion here takes


def cycle(k):
    """One cycle: the step that is commanded to each joint from where the controller commands it. The controller
    follows. None when no answer came."""
    k.follows = False  # judged here
    before = k.total
    a = k.turn()
    if not a:
        return None
    step = [x - y for x, y in zip(a.q, before)]
    for i, by in enumerate(step):
        assert abs(by) <= VELOCITY[i] * k.period + ROUNDING, f"A{i + 1} steps by {by:.5f} rad in {1e3 * k.period:g} ms"
    k.fri = [single(x - y) for x, y in zip(a.q, k.krl)]
    return step


def moving(k, joint, by):
    """Until `joint` has been commanded so far from where command mode began; where that was."""
    k.until(lambda a: k.state == CMD)
    start = k.total[joint]
    for _ in range(MANY):
        assert cycle(k) and k.state == CMD, "command mode was left before it was under way"
        if abs(k.total[joint] - start) >= by:
            return start
    raise AssertionError("it does not move")


def lies_about_its_time(colift, claims, paced):
    """The controller says other sample times in the middle of a motion, its datagrams come as before. Whoever believes
    them takes larger steps: limits of a step and the time along a motion are proportional to the sample time."""
    k = Krc(colift, "move-joint", "4", "5", "--speed", "12", period=0.002)
    k.paced = paced
    start, n, fastest = moving(k, 3, 0.02), 0, 0.0
    while k.state == CMD:
        k.claimed = claims[n % len(claims)]
        step = cycle(k)
        assert step, f"no answer in command mode, {claims}"
        fastest = max(fastest, abs(step[3]) / k.period)
        n += 1
        assert n < MANY, "the motion does not end"
    d = k.finish(0)
    assert n > 100 and abs(math.degrees(k.total[3] - start) - 5.0) < 0.01, (claims, n, k.total, d["result"])
    # nor is it faster than it was asked to be
    assert math.degrees(fastest) < 12.5, (claims, math.degrees(fastest))


def sample_time_jumps(colift):
    """As fast as the answers come, so that no sample time agrees with the arrivals; 0.1 s is one that FRI can have."""
    for claims in ((0.5,), (0.5, 0.002), (0.1,), (0.0, 0.5, 0.1, 1.0)):
        lies_about_its_time(colift, claims, False)


def sample_time_jumps_in_time(colift):
    """Each 2 ms by the clock, so that the sample time before the jump was believed."""
    lies_about_its_time(colift, 40 * (0.5,) + 40 * (0.1,), True)


def unheard(k, answered=lambda a: None):
    """Measurements go out in the controller's time, answered or not, until the program ends."""
    k.follows = False
    end = time.monotonic() + 20
    while k.process.poll() is None:
        assert time.monotonic() < end, "the program does not end"
        k.await_period()
        k.emit()
        a = k.collect(k.period)
        if a:
            answered(a)


def counter_set_back(colift):
    """Its counter falls back by 300, to numbers that it has used, without a gap in what comes."""
    def answered(a):
        assert max(abs(x - y) for x, y in zip(a.q, k.total)) < ROUNDING, "moved although the count is not certain"
        k.program(a)

    # whether the silence or the new count is noticed first depends on the period
    for verb, period in ((("hold", "--for", "60"), PERIOD), (("move-joint", "4", "30", "--speed", "6"), PERIOD),
                         (("move-joint", "4", "30", "--speed", "2"), 0.03)):
        k = Krc(colift, *verb, period=period)
        k.commanding()
        k.turns(310)
        assert k.state == CMD
        k.send -= 300
        k.answered.clear()
        unheard(k, answered)
        d = k.finish(3)
        because = d["result"]["because"]
        assert d["result"]["outcome"] == "lost" and "counts its datagrams anew" in because, because
        by = re.search(r"\(([-+][0-9]+)\)", because)
        assert not by or abs(int(by.group(1)) + 300) <= 1, because  # from the last one or from the next one
        assert "cable" not in because.replace("it is not the cable", ""), because
        assert k.starts == 1, "asked for command mode again by itself"


# fields that neither a command nor the hand-shake depends on, and what the message has to name
UNUSED = ((8 + 4 * 15, "real variable of the KRL program"), (140, "time stamp"), (396, "frame"), (444 + 4 * 2, "torque"),
          (500, "wrench"), (524 + 4 * 41, "Jacobian"), (692 + 4 * 48, "mass matrix"), (888, "gravity"))


def with_nan(k, offset):
    sound = type(k).measurement

    def measurement():
        b = sound(k)
        struct.pack_into("<f", b, offset, math.nan)
        return b
    k.measurement = measurement


def nan_at_start(colift):
    """Not one measurement is sound, by a field that is not used."""
    for offset, words in UNUSED:
        k = Krc(colift, "hold", first_s=0.5)
        with_nan(k, offset)
        d = k.finish(3)
        assert not k.answers and d["result"]["outcome"] == "refused", (offset, d["result"])
        assert words in d["result"]["because"] and "not finite" in d["result"]["because"], (offset, d["result"])


def nan_later(colift):
    """All measurements are unsound from one in command mode on. They come, all the same: it is not the cable."""
    for offset, words in UNUSED:
        k = Krc(colift, "hold")
        k.commanding()
        with_nan(k, offset)
        said = len(k.answers)
        unheard(k)
        d = k.finish(3)
        because = d["result"]["because"]
        assert len(k.answers) == said, "an unsound measurement was answered"
        assert d["result"]["outcome"] == "lost", d["result"]
        assert words in because and "not finite" in because, (offset, because)
        assert "cable" not in because.replace("it is not the cable", ""), because


class Loaded(Krc):
    """Something hangs on A2 that no load data tell of: the joint gives way by torque over stiffness."""

    LOAD = 15.0

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, **options)
        self.external[1] = self.LOAD
        self.hang(1000.0)

    def hang(self, stiffness):
        self.sag[1] = self.LOAD / stiffness

    def take(self, a):
        super().take(a)
        self.hang(a.stiffness[1] if self.state == CMD else 1000.0)


def unexplained_load(colift):
    """Each start begins at the measured pose, 15 mrad below the commanded one: five of them must not add up."""
    for verb in (("hold", "--for", "0.6"), ("move-joint", "4", "0.5")):
        fri, poses = [0.0] * 7, []
        for _ in range(5):
            k = Loaded(colift, *verb)
            k.fri = fri
            k.until(lambda a: k.state == CMD)
            d = k.finish(0)
            assert k.state == MON and d["result"]["outcome"] == "done", d["result"]
            fri = k.fri
            poses.append(k.total[1])
            kinds = [o["kind"] for o in d["command_mode"]["obstacles"]]
            assert "unexplained-load" in kinds, kinds
        sunk = [math.degrees(q - single(k.krl[1])) for q in poses]
        assert all(abs(by) < 0.2 for by in sunk), f"{verb[0]}: A2 sinks from start to start: {sunk} deg"


def hang_up(k):
    for _ in range(5):  # a terminal that is closed may say it several times
        k.process.send_signal(signal.SIGHUP)
        for _ in range(3):
            yield


def close_pipe(k):
    k.process.stdout.close()
    k.process.stdout = None  # communicate() would read it
    yield


def close_pipes(k):
    k.process.stderr.close()
    k.process.stderr = None
    yield from close_pipe(k)


def leaves(colift, verb, end, json=True):
    """Ended in command mode: it brakes, asks for monitor mode, and goes."""
    k = Krc(colift, *verb, json=json)
    k.paced = True  # how soon it is noticed is a matter of real time
    if verb[0] == "hold":
        k.commanding()
        start = None
    else:
        start = moving(k, 3, 0.15)  # where it is fast enough that a stop without braking shows
    told, before, steps = end(k), None, []
    while k.state == CMD:
        next(told, None)
        step = cycle(k)
        assert step, f"it ended in command mode, with {k.process.poll()}"
        for i in range(7) if before else ():
            change = abs(step[i] - before[i]) / k.period
            most = ACCELERATION * k.period + 2 * ROUNDING / k.period
            assert change <= most, f"A{i + 1} changes its speed by {change:.3f} rad/s"
        before = step
        steps.append(step)
        assert len(steps) < 300, "command mode is not left"
    assert len(steps) > 2 and max(map(abs, steps[-1] + steps[-2])) <= ROUNDING, f"not at rest: {steps[-1]}"
    if start is None:
        assert not any(max(map(abs, s)) > ROUNDING for s in steps), "it moved"
    else:
        assert 0.15 < k.total[3] - start < math.radians(25.0), f"ended {k.total[3] - start:.3f} rad from its start"
    end_of_it = time.monotonic() + 20
    while k.process.poll() is None:
        assert time.monotonic() < end_of_it, "the program does not end"
        k.turn()  # mirrored from here on
    assert k.state == MON and k.starts == 1 and k.answers[-1].int[15] != 10, (k.state, k.starts)
    return k


VERBS = (("hold", "--for", "60"), ("move-joint", "4", "28", "--speed", "40", "--yes"))


def terminal_hangs_up(colift):
    for verb in VERBS:
        d = leaves(colift, verb, hang_up).finish(130)
        assert d["result"]["outcome"] == "interrupted" and d["result"]["because"] == "asked to end", d["result"]


def reader_goes(colift):
    """The pipe behind stdout is closed before anything was written to it; then stderr's too, where progress goes."""
    for verb in VERBS:
        for end, json in ((close_pipe, True), (close_pipe, False), (close_pipes, False)):
            k = leaves(colift, verb, end, json)
            told = k.process.communicate(timeout=10)[1]
            assert k.process.returncode == 130, (k.process.returncode, told)
            k.socket.close()
            k.folder.cleanup()


TESTS = (sample_time_jumps, sample_time_jumps_in_time, counter_set_back, nan_at_start, nan_later, unexplained_load,
         terminal_hangs_up, reader_goes)

if __name__ == "__main__":
    sys.exit(main(TESTS, Krc, attempts=8, at_once=2))
