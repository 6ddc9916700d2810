#!/usr/bin/env python3
"""Drives `colift hal arm` as a KRC would: what is asked, mirrored and moved is judged at the far end of the wire. A test
in which this controller itself was held up for several periods is begun anew.

Standard library only, and nothing of CoLift's own code. Usage: fri_server_test.py COLIFT [NAME...]
"""

import json
import math
import os
import select
import socket
import struct
import subprocess
import sys
import tarfile
import tempfile
import time

from fri_server import CMD, MON, PERIOD, Krc, single
from wire_tests import main


def near(found, expected, what):
    assert len(found) == len(expected) and all(abs(a - b) < 1e-5 for a, b in zip(found, expected)), (what, found)


def every_field(colift):
    k = Krc(colift, "state", "--for", "0.5")
    k.int[14], k.int[15] = 30, 10
    k.fri = [0.01 * i for i in range(7)]
    k.sag = [0.001 * i for i in range(7)]
    k.celsius = [31.0 + i for i in range(7)]
    k.tau = [1.0, -2.0, 3.0, -4.0, 5.0, -6.0, 7.0]
    k.external = [0.1, 0.2, -0.3, 0.4, -0.5, 0.6, 0.7]
    k.wrench = [1.0, 2.0, 3.0, 0.3, 0.2, 0.1]  # Fx Fy Fz Tz Ty Tx
    k.warning = 0x02
    k.until(lambda a: len(k.answers) > 100)
    d = k.finish(0)
    assert d["schema"] == "colift.hal.arm/1" and k.answers[-1].flags == 0x35, k.answers[-1].flags
    joints = d["joints"]
    near([j["measured"] for j in joints], k.measured, "measured")
    near([j["commanded"] for j in joints], k.total, "commanded")
    near([j["torque"] for j in joints], k.tau, "torque")
    near([j["external_torque"] for j in joints], k.external, "external torque")
    near([j["temperature_c"] for j in joints], k.celsius, "temperature")
    assert [j["warning"] for j in joints] == [False, True] + [False] * 5
    near(d["tcp_wrench"], [1.0, 2.0, 3.0, 0.1, 0.2, 0.3], "wrench")
    c = d["connection"]
    assert (c["state"], c["quality"], c["missed_by_krc"]) == ("monitor", "perfect", 3), c
    near([c["answer_rate"], c["latency_ms"], c["jitter_ms"], c["period_ms"]], [0.995, 0.5, 0.1, 12.0], "statistics")
    # one answer for each measurement, and some more after the figures were taken: the words are cleared at the end
    assert 0 <= len(k.answers) - c["answered"] <= 10 and 0 <= c["received"] - c["answered"] <= 1, (len(k.answers), c)


def hold(colift):
    k = Krc(colift, "hold", "--for", "0.4")
    k.send = 65500  # the counter wraps while commanding
    k.commanding()
    pose = k.measured
    d = k.finish(0)
    assert d["result"]["outcome"] == "done" and k.state == MON and k.starts == 1, d["result"]
    near(k.measured, pose, "it moved")
    near(d["result"]["start"], pose, "start")
    # the program hears no stale word afterwards
    assert k.answers[-1].int[15] != 10


def other_programs(colift):
    for script in ("vendor", "tum", "none"):
        k = Krc(colift, "hold", "--for", "0.3", script=script)
        k.commanding()
        if script == "tum":
            assert k.answers[-1].bool & 0x80, "FRM_BOOL[8] does not tell of command mode"
        if script == "none":
            k.until(lambda a: len(k.answers) > 300)
            k.state = MON  # the person again
        d = k.finish(0)
        assert d["result"]["outcome"] == "done" and k.state == MON, (script, d["result"])


def hold_on_springs(colift):
    """Measured and commanded differ: the first answer is what the controller commands, then a walk to the measured."""
    k = Krc(colift, "hold", "--for", "2")
    k.sag = [0.0, 0.012, 0.0, -0.006, 0.0, 0.0, 0.0]
    k.follows = False  # judged here
    k.until(lambda a: k.state == CMD)
    last, speed, hangs = list(k.total), [0.0] * 7, k.measured
    for _ in range(100):
        a = k.turn()
        assert a
        for i in range(7):
            v = (a.q[i] - last[i]) / PERIOD
            assert abs(v) < 0.21 and abs(v - speed[i]) / PERIOD < 2.5, (i, v, speed[i])
            speed[i] = v
        last = list(a.q)
        k.fri = [single(x - y) for x, y in zip(a.q, k.krl)]
    near(last, hangs, "did not arrive at the measured pose")
    k.finish(0)


def move_joint(colift):
    k = Krc(colift, "move-joint", "4", "9", "--speed", "12")
    k.until(lambda a: k.state == CMD)
    start, before, fastest = list(k.total), list(k.total), 0.0
    while k.state == CMD and k.turn():
        fastest = max(fastest, abs(k.total[3] - before[3]) / PERIOD)
        assert all(abs(k.total[i] - start[i]) < 1e-5 for i in range(7) if i != 3), "another joint moved"
        before = list(k.total)
    d = k.finish(0)
    assert abs(math.degrees(k.total[3] - start[3]) - 9.0) < 0.01, k.total
    assert 11.0 < math.degrees(fastest) < 12.5, math.degrees(fastest)
    assert d["result"]["joint"] == "A4" and abs(math.degrees(d["result"]["moved"]) - 9.0) < 0.1, d["result"]


def never_twice(colift):
    """Doubled, late, broken and foreign datagrams get no answer, and cost the good ones none."""
    k = Krc(colift, "watch", "--for", "1.0")
    k.int[14], k.int[15] = 30, 10
    k.until(lambda a: len(k.answers) > 20)
    foreign = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    foreign.bind(("127.0.0.1", 0))
    good = 0
    for i in range(200):
        old = bytes(k.measurement())
        if not k.turn():
            break
        good += 1
        spoilt = k.measurement()
        struct.pack_into("<H", spoilt, 0, (k.send + 1) % 65536)
        nan, far, short, ident, size = (bytearray(spoilt) for _ in range(5))
        struct.pack_into("<f", nan, 216 + 4 * (i % 7), math.nan)
        struct.pack_into("<f", far, 216 + 4 * (i % 7), 4.0)
        struct.pack_into("<H", ident, 6, 0x1005)
        struct.pack_into("<H", size, 4, 915)
        k.out(k.measurement())  # doubled
        k.out(old)
        for bad in (nan, far, short[:-1], short + b"\0", ident, size, b""):
            k.out(bytes(bad))
        k.out(bytes(spoilt), foreign)
    assert not select.select([foreign], [], [], 0.05)[0], "a foreign sender was answered"
    d = k.finish(0)
    assert good > 20 and d["connection"]["dropped"] >= 9 * (good - 2), (good, d["connection"])
    assert all(times == 1 for times in k.answered.values())
    foreign.close()


def gap(colift):
    """Twenty measurements do not arrive while a joint moves: at rest, then from the measured pose."""
    k = Krc(colift, "move-joint", "2", "10", "--speed", "12")
    k.commanding()
    start = k.total[1]
    k.until(lambda a: k.total[1] - start > 0.03)
    for _ in range(20):
        k.next()
    k.fri[1] = single(k.fri[1] + 0.004)  # where the controller brought it to rest
    rest = k.measured
    a = k.turn()
    assert a and list(a.q) == k.total and list(a.q) == rest, "an old target was resumed"
    for _ in range(15):
        a = k.turn()
        assert a and max(abs(x - y) for x, y in zip(a.q, rest)) < 1e-6, "it moved without being asked anew"
    d = k.finish(1)
    assert d["result"]["restarts"] == 1 and "cut off" in d["result"]["because"], d["result"]


def single_losses(colift):
    """One to three lost measurements are spanned without a step; the controller extrapolates meanwhile."""
    k = Krc(colift, "move-joint", "2", "4", "--speed", "12")
    k.until(lambda a: k.state == CMD)
    start, n, before, speed = k.total[1], 0, k.total[1], 0.0
    while k.state == CMD and k.turn():
        n += 1
        v = (k.total[1] - before) / PERIOD
        assert abs(v - speed) <= 0.12, (n, v, speed)
        before, speed = k.total[1], v
        if n % 25 == 0:
            lost = 1 + n // 25 % 3
            for _ in range(lost):
                k.next()
            k.fri[1] = single(k.fri[1] + lost * v * PERIOD)
            before = k.total[1]
    d = k.finish(0)
    assert d["result"]["restarts"] == 0 and d["connection"]["lost"] > 3, d
    assert abs(math.degrees(k.total[1] - start) - 4.0) < 0.02, k.total[1]


def quality(colift):
    """Unacceptable for a while: no command, at rest; well again: from the measured pose."""
    k = Krc(colift, "hold", "--for", "1.5")
    k.commanding()
    pose = list(k.total)
    k.quality = 0
    for _ in range(40):
        k.turns(1)
        near(k.total, pose, "moved at unacceptable quality")
    k.quality = 3
    k.turns(30)
    d = k.finish(0)
    assert d["result"]["restarts"] == 1, d["result"]
    near(k.total, pose, "moved")


def monitor(colift):
    k = Krc(colift, "hold")
    k.commanding()
    k.state, k.starts = MON, 0
    k.turns(5)
    d = k.finish(3)
    assert k.starts == 0, "asked for command mode again by itself"
    assert d["result"]["outcome"] == "lost" and "left command mode" in d["result"]["because"], d["result"]


def drives_off(colift):
    k = Krc(colift, "hold")
    k.commanding()
    k.power, k.error = 0, 0x04
    k.turns(5)  # mirrored, or take() says no
    d = k.finish(3)
    assert "drive error of A3" in d["result"]["because"], d["result"]


def silence(colift):
    k = Krc(colift, "hold")
    k.commanding()
    began = time.monotonic()
    out, err = k.process.communicate(timeout=30)
    assert k.process.returncode == 3 and time.monotonic() - began < 20, (k.process.returncode, err)
    d = json.loads(out)
    assert d["result"]["outcome"] == "lost" and "no datagram" in d["result"]["because"], d["result"]
    k.socket.close()


def strategies(colift):
    """Position control and Cartesian impedance, by a program that takes them."""
    for control, strategy, flags in (("position", 10, 0x1), ("cartesian_impedance", 20, 0x3500)):
        k = Krc(colift, "hold", "--for", "0.4", "--control", control)
        k.switches = True
        k.commanding()
        pose = k.measured
        k.turns(10)
        assert k.answers[-1].flags == flags, hex(k.answers[-1].flags)
        if flags & 0x100:
            near(k.answers[-1].frame, [1, 0, 0, 0.5, 0, 1, 0, 0.1, 0, 0, 1, 0.4], "the frame that was measured")
        d = k.finish(0)
        assert d["result"]["control"] == control and k.strategies == [strategy] and k.state == MON, d["result"]
        near(k.measured, pose, "it moved")
    k = Krc(colift, "move-joint", "4", "5", "--speed", "12", "--control", "position")
    k.switches = True
    k.until(lambda a: k.state == CMD)
    start = k.total[3]
    k.until(lambda a: k.state == MON)
    k.finish(0)
    assert abs(math.degrees(k.total[3] - start) - 5.0) < 0.01, k.total


def other_hand_shakes(colift):
    """Programs of the Centro Piaggio (position control first) and of OpenKC, in each strategy."""
    for script in ("cep", "openkc"):
        for control, strategy in (("joint_impedance", 30), ("position", 10), ("cartesian_impedance", 20)):
            k = Krc(colift, "hold", "--for", "0.3", "--control", control, script=script)
            k.until(lambda a: k.state == CMD and k.strategies[-1] == strategy)
            d = k.finish(0)
            detour = script == "cep" and strategy != 10
            assert k.strategies == ([10, strategy] if detour else [strategy]), (script, control, k.strategies)
            assert d["result"]["outcome"] == "done" and k.state == MON, d["result"]


SWITCH = ("switch", "joint_impedance", "position", "cartesian_impedance", "--for", "0.3")


def switch(colift):
    """One strategy after the other on one link; the flags change in monitor mode only."""
    for script, expected in (("stanford", [30, 10, 20]), ("cep", [10, 30, 10, 20]), ("openkc", [30, 10, 20])):
        k = Krc(colift, *SWITCH, script=script)
        k.switches = True
        pose = k.measured
        d = k.finish(0)
        assert k.strategies == expected, (script, k.strategies)
        steps = d["result"]["switches"]
        assert [s["control"] for s in steps] == list(SWITCH[1:4]) and all(s["reached"] for s in steps), steps
        near(k.measured, pose, "it moved")


def switch_refused(colift):
    """The controller stays in monitor mode at the second strategy: at rest, named, and no further one is tried."""
    k = Krc(colift, *SWITCH, more=", ready_s: 1.5")
    k.switches, k.stays_in_monitor = True, (10,)
    pose = k.measured
    d = k.finish(3)
    assert k.strategies == [30, 10] and k.state == MON, k.strategies
    assert [s["reached"] for s in d["result"]["switches"]] == [True, False], d["result"]
    assert "position: " in d["result"]["because"] and "stays in monitor mode" in d["result"]["because"], d["result"]
    near(k.measured, pose, "it moved")


def switch_bad_moments(colift):
    """Quality, drives and command mode go between two strategies."""
    def quality(k):
        k.quality = 0

    def drives(k):
        k.power, k.error = 0, 0x02

    for spoil, words in ((quality, "the quality of the connection is unacceptable"), (drives, "drive error of A2")):
        k = Krc(colift, *SWITCH, more=", ready_s: 1.5")
        k.switches = True
        pose = k.measured
        k.until(lambda a: k.state == CMD)
        k.until(lambda a: k.state == MON)
        spoil(k)
        d = k.finish(3)
        assert k.strategies == [30] and words in d["result"]["because"], (k.strategies, d["result"])
        near(k.measured, pose, "it moved")


def switch_no_answer(colift):
    """The program is halted at the panel after the first strategy."""
    k = Krc(colift, *SWITCH, script="openkc", more=", script_s: 0.5")
    k.until(lambda a: k.state == CMD)
    k.until(lambda a: k.state == MON and not k.bool)
    k.script = "halted"
    k.halted = lambda a: None
    d = k.finish(3)
    assert "does not answer within 0.5 s" in d["result"]["because"] and k.strategies == [30], d["result"]


def two_senders(colift):
    """A second sender that speaks first: nobody is asked for command mode, and both are named."""
    k = Krc(colift, "hold", krc="")
    hostile = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    hostile.bind(("127.0.0.1", 0))
    heard = 0
    while k.process.poll() is None:
        k.next()
        for sender in (hostile, k.socket):
            k.out(k.measurement(), sender)
        for ready in select.select([hostile, k.socket], [], [], 0.01)[0]:
            data = ready.recv(2000)
            heard += 1
            assert struct.unpack_from("<i", data, 72 + 4 * 15)[0] != 10, "a sender that is not certain was asked to start"
    out, err = k.process.communicate(timeout=10)
    assert k.process.returncode == 3 and heard > 0, (k.process.returncode, heard, err)
    because = json.loads(out)["result"]["because"]
    for sender in (hostile, k.socket):
        assert "127.0.0.1:%d" % sender.getsockname()[1] in because, because
    assert "two senders" in because and "krc: 127.0.0.1" not in because, because
    hostile.close()
    k.socket.close()


def doctor(colift):
    """The bundle is made from a healthy controller, one that refuses, and one that is not there; nothing is overwritten."""
    def parts(file):
        with tarfile.open(file) as tar:
            return {os.path.basename(m.name): tar.extractfile(m).read().decode() for m in tar}

    with tempfile.TemporaryDirectory() as folder:
        good, bad, none = (os.path.join(folder, name + ".tar") for name in ("good", "bad", "none"))
        k = Krc(colift, "doctor", "--out", good)
        k.int[14], k.int[15] = 30, 10
        d = k.finish(0)
        assert d["verb"] == "doctor" and k.starts == 0, "it asked for command mode"
        found = parts(good)
        assert set(found) == {"state.txt", "answers.txt", "obstacles.txt", "state.json", "machine.txt", "config.yaml"}, set(found)
        assert json.loads(found["state.json"])["connection"]["received"] > 50
        assert "quality" in found["state.txt"] and "script: stanford" in found["config.yaml"], found
        assert "no obstacle found" in found["obstacles.txt"], found["obstacles.txt"]

        k = Krc(colift, "doctor", "--out", bad)
        k.error, k.power, k.quality = 0x04, 0, 1
        k.finish(0)
        assert "drive error of A3" in parts(bad)["obstacles.txt"] and "the quality is bad" in parts(bad)["obstacles.txt"]

        rig = os.path.join(folder, "rig.yaml")
        with open(rig, "w") as f:
            f.write("arm: fri\nemulator: never\nfri: {address: 127.0.0.1, port: 0, first_s: 0.3}\n")
        run = lambda: subprocess.run([colift, "hal", "arm", "doctor", "--robot", rig, "--out", none], capture_output=True, text=True)
        done = run()
        assert done.returncode == 3, done
        assert "nothing usable comes" in parts(none)["obstacles.txt"], parts(none)
        again = run()
        assert again.returncode == 2 and "exists already" in again.stderr, again


def refusals(colift):
    for spoil, code, words in ((lambda k: setattr(k, "external", [0, 25.0, 0, 0, 0, 0, 0]), 3, "external torque on A2: 25.0 N m"),
                               (lambda k: setattr(k, "celsius", [90.0] * 7), 3, "90 deg C"),
                               (lambda k: setattr(k, "error", 0x01), 3, "drive error of A1"),
                               (lambda k: setattr(k, "control", 1), 3, "position control")):
        k = Krc(colift, "hold")
        spoil(k)
        d = k.finish(code)
        assert words in d["result"]["because"], d["result"]


TESTS = (every_field, hold, other_programs, hold_on_springs, move_joint, never_twice, gap, single_losses, quality, monitor, drives_off,
         silence, strategies, other_hand_shakes, switch, switch_refused, switch_bad_moments, switch_no_answer, two_senders, doctor,
         refusals)


if __name__ == "__main__":
    sys.exit(main(TESTS, Krc, attempts=8))
