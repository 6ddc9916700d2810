#!/usr/bin/env python3
"""Drives `colift emulate krc --plant light` as a client of FRI 1.x would, over UDP.

All but one test let the emulator take a step for each answer (--speed 0): a busy machine only makes them slower.
Standard library only, and nothing of CoLift's own code: what is read and written here stands in the public layout of
the two datagrams (916 and 376 bytes, little endian). Usage: fri_client_test.py COLIFT [NAME...]
"""

import json
import math
import select
import signal
import socket
import struct
import subprocess
import sys
import time

MEASUREMENT, COMMAND = 916, 376
# header, KRL block, interface, robot, data: each as one format
HEAD = struct.Struct("<4H")
KRL = struct.Struct("<16f16iHH")
INTERFACE = struct.Struct("<fHH7fI")
ROBOT = struct.Struct("<4H7f")
DATA = struct.Struct("<175f")
CMD = struct.Struct("<I58f")
assert HEAD.size + KRL.size + INTERFACE.size + ROBOT.size + DATA.size == MEASUREMENT
assert HEAD.size + KRL.size + CMD.size == COMMAND

MON, CMDMODE = 1, 2


class Measurement:
    def __init__(self, data):
        assert len(data) == MEASUREMENT, len(data)
        self.send, self.reflected, size, ident = HEAD.unpack_from(data, 0)
        assert (size, ident) == (MEASUREMENT, 0x2006)
        krl = KRL.unpack_from(data, 8)
        self.real, self.int, self.bool = krl[:16], krl[16:32], krl[32]
        i = INTERFACE.unpack_from(data, 140)
        (self.time, self.state, self.quality, self.period, self.cmd_period, self.safety, self.rate, self.latency,
         self.jitter, self.miss_rate, self.missed) = i
        r = ROBOT.unpack_from(data, 180)
        self.power, self.control, self.error, self.warning = r[:4]
        d = DATA.unpack_from(data, 216)
        self.q, self.frame, self.q_krl, self.q_fri = d[0:7], d[7:19], d[19:26], d[26:33]
        self.tau, self.tau_external, self.wrench = d[57:64], d[64:71], d[71:77]
        self.jacobian, self.mass, self.gravity = d[77:119], d[119:168], d[168:175]
        self.total = [a + b for a, b in zip(self.q_krl, self.q_fri)]


class Client:
    """One session: the emulator as a child, a socket of our own, one answer for each measurement."""

    def __init__(self, colift, script, *options, speed=0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        port = self.socket.getsockname()[1]
        self.process = subprocess.Popen(
            [colift, "emulate", "krc", "--to", f"127.0.0.1:{port}", "--plant", "light", "--script", script, "--json",
             "--cycle-ms", "4", "--linger-s", "0.3", "--speed", str(speed), *options],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        ready = self.process.stderr.readline()
        assert ready.startswith("ready: "), ready
        self.send, self.last = 0, None
        self.real, self.int, self.bool = [0.0] * 16, [0] * 16, 0
        self.flags, self.q, self.tau = 0x35, None, [0.0] * 7
        self.wire = None  # a last change of the bytes

    def receive(self, patience=1.0):
        if not select.select([self.socket], [], [], patience)[0]:
            return None
        data, self.peer = self.socket.recvfrom(2000)
        self.last = Measurement(data)
        return self.last

    def answer(self):
        m = self.last
        self.send = (self.send + 1) % 65536
        q = m.total if self.q is None or m.state != CMDMODE else self.q
        body = (list(q) + list(m.frame) + self.tau + [0.0] * 6 + [1000.0] * 7 + [0.7] * 7 + [2000.0] * 3 +
                [200.0] * 3 + [0.7] * 6)
        data = bytearray(HEAD.pack(self.send, m.send, COMMAND, 0x1005) +
                         KRL.pack(*self.real, *self.int, self.bool, 0) + CMD.pack(self.flags, *body))
        if self.wire:
            self.wire(data)
        self.socket.sendto(data, self.peer)

    def turn(self, patience=1.0):
        m = self.receive(patience)
        if m:
            self.answer()
        return m

    def until(self, done, seconds=4.0, each=None):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            m = self.turn()
            assert m, "no measurement came for 1 s"
            if each:
                each(m)
            if done(m):
                return m
        raise AssertionError(f"did not happen in {seconds} s; state {m.state}, quality {m.quality}, ints {m.int}")

    def turns(self, n):
        for _ in range(n):
            assert self.turn()

    def move(self, seconds=0.4, joint=3, radius=0.02):
        """A small motion away from the start and back."""
        start, began = list(self.last.total), self.last.time
        while self.last.state == CMDMODE:
            t = self.last.time - began
            if t > seconds:
                break
            self.q = list(start)
            self.q[joint] += radius * 0.5 * (1.0 - math.cos(2.0 * math.pi * t / seconds))
            assert self.turn()
        self.q = list(start)
        return start

    def end(self, code, interrupt=True):
        if interrupt and self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        out, err = self.process.communicate(timeout=10)
        self.socket.close()
        self.report, self.told = json.loads(out), err
        assert self.report["schema"] == "colift.emulate/1"
        assert self.process.returncode == code, (self.process.returncode, code, err, self.report["broken_rules"])
        return self.report

    def drain(self):
        """Answers until the controller is silent; its last measurement."""
        while self.turn(0.5):
            pass
        return self.last


def rules(report):
    return [b["rule"] for b in report["broken_rules"]]


def flange(q):
    """Forward kinematics of the LWR 4+ from its published distances (standard Denavit-Hartenberg): a 3 by 4 frame."""
    alphas, ds = (90, -90, -90, 90, 90, -90, 0), (0.3105, 0, 0.4, 0, 0.39, 0, 0.078)
    frame = [[float(i == j) for j in range(4)] for i in range(4)]
    for angle, alpha, d in zip(q, alphas, ds):
        c, s, ca, sa = math.cos(angle), math.sin(angle), math.cos(math.radians(alpha)), math.sin(math.radians(alpha))
        link = [[c, -s * ca, s * sa, 0], [s, c * ca, -c * sa, 0], [0, sa, ca, d], [0, 0, 0, 1]]
        frame = [[sum(a * link[k][j] for k, a in enumerate(row)) for j in range(4)] for row in frame]
    return [x for row in frame[:3] for x in row]


def offsets(colift):
    """Fields at their published offsets, counted from the first byte: bytes and physics, not the formats above."""
    c = Client(colift, "stanford")
    data, c.peer = c.socket.recvfrom(2000)
    assert len(data) == 916 and data[:8] == bytes.fromhex("0100000094030620"), data[:8].hex()
    assert data[144:146] == b"\1\0" and data[148:156] == bytes.fromhex("6f12833b6f12833b"), data[144:156].hex()
    assert data[180:184] == bytes.fromhex("7f000100") and data[184:188] == bytes(4), data[180:188].hex()
    at = lambda offset, n: struct.unpack_from(f"<{n}f", data, offset)
    q, krl, fri, jacobian, mass = at(216, 7), at(292, 7), at(320, 7), at(524, 42), at(692, 49)
    assert all(abs(m - a - b) < 1e-4 for m, a, b in zip(q, krl, fri)), (q, krl, fri)
    for found in (at(244, 12), at(348, 12)):
        assert all(abs(a - b) < 1e-4 for a, b in zip(found, flange(q))), (found, flange(q))
    # rows X Y Z RZ RY RX: the first axis stands upright, and lifts nothing
    assert abs(jacobian[2 * 7]) < 1e-6 and abs(jacobian[3 * 7] - 1.0) < 1e-6, jacobian
    assert all(abs(mass[7 * i + j] - mass[7 * j + i]) < 1e-4 for i in range(7) for j in range(7)) and mass[0] > 0.1
    assert abs(at(888, 7)[0]) < 1e-3 and all(0 < t < 60 for t in at(188, 7))
    c.receive()
    c.answer()
    c.end(0)


def stanford(colift):
    c = Client(colift, "stanford")
    c.turns(5)
    assert c.last.state == MON and c.last.int[14] == 30 and c.last.int[15] == 10
    assert c.last.power == 0x7F and abs(c.last.period - 0.004) < 1e-7 and c.last.cmd_period == c.last.period
    c.until(lambda m: m.quality >= 2)
    assert c.last.rate > 0.94 and 0 < c.last.latency <= 0.004, (c.last.rate, c.last.latency)
    c.int[14], c.int[15] = 30, 10
    c.until(lambda m: m.state == CMDMODE and m.power)
    assert c.last.control == 3
    krl = c.last.q_krl
    c.move()
    assert c.last.q_krl == krl, "cmdJntPos moved with FRI"
    c.int[15] = 20
    c.until(lambda m: m.state == MON)
    c.until(lambda m: m.int[15] == 10)
    c.int[15] = c.last.int[14]
    c.until(lambda m: m.int[15] == 30)
    c.drain()
    report = c.end(0, interrupt=False)
    assert [m["to"] for m in report["mode_changes"]] == ["monitor", "command", "monitor", "off"], report
    assert report["packets"]["answered"] >= report["packets"]["sent"] - report["packets"]["missed"] - 1
    assert report["because"] == "the client asked for the end", report["because"]


def tum(colift):
    c = Client(colift, "tum")
    c.until(lambda m: m.quality >= 2)
    assert c.last.control == 3

    def request(what):
        c.int[0], c.bool = what, c.bool | 1
        c.until(lambda m: m.bool & 1)
        c.bool &= ~1
        c.until(lambda m: not m.bool & 1)

    request(1)
    c.until(lambda m: m.state == CMDMODE)
    c.bool |= 0x80
    c.move()
    request(2)
    c.until(lambda m: m.state == MON)
    assert c.last.power == 0x7F
    c.end(0)


def vendor(colift):
    c = Client(colift, "vendor", "--session-s", "0.6")
    c.flags = 0x01
    c.int[0] = 1

    def mirror(m):
        c.real[0] = m.real[1]
        if m.quality >= 2:
            c.int[0] = 10

    c.until(lambda m: m.state == CMDMODE, each=mirror)
    assert c.last.control == 1
    # the sample adds its motion to cmdJntPos, which therefore has to stand still
    base, began = list(c.last.q_krl), c.last.time
    while c.last.int[0] != -1:
        mirror(c.last)
        c.q = [b + o for b, o in zip(c.last.q_krl, [0.0, 0.02 * math.sin(3.0 * (c.last.time - began))] + [0.0] * 5)]
        assert c.turn()
        assert list(c.last.q_krl) == base
    c.drain()
    assert c.end(0, interrupt=False)["because"] == "the program ended the session"


def colift_program(colift):
    c = Client(colift, "colift")
    c.int[0] = 10001
    beat = 0

    def heart(m):
        nonlocal beat
        beat += 1
        c.int[4] = beat // 13 % 30000 + 1

    c.until(lambda m: m.int[0] == 10001, each=heart)
    c.int[3] = c.last.int[3]

    def ask(what, strategy=0):
        c.int[1], c.int[2], c.int[3] = what, strategy, c.int[3] % 30000 + 1
        c.until(lambda m: m.int[3] == c.int[3] and m.int[5] != 0, each=heart)
        return c.last.int[5]

    assert ask(1, 30) == 1 and c.last.state == CMDMODE and c.last.int[1] == 3
    c.move()
    assert ask(2) == 1 and c.last.state == MON
    assert ask(1, 25) == 3
    assert ask(3) == 1
    c.drain()
    c.end(0, interrupt=False)


def cep(colift):
    """Position control first, then the strategy that is asked for; perfect quality is waited for."""
    c = Client(colift, "cep")
    c.until(lambda m: m.int[1] == 10)
    c.flags, c.int[0], c.int[1] = 0x01, 30, 1
    c.until(lambda m: m.state == CMDMODE)
    assert c.last.control == 1 and c.last.quality == 3
    c.until(lambda m: m.int[1] == 1)
    c.int[1] = 0
    c.until(lambda m: m.state == MON and m.int[1] == 0)
    c.flags, c.int[1] = 0x35, 1
    c.until(lambda m: m.state == CMDMODE and m.power)
    assert c.last.control == 3
    c.move()
    c.end(0)


def openkc(colift):
    c = Client(colift, "openkc")
    c.until(lambda m: m.quality >= 2)

    def command(number, code):
        count = c.last.int[13]
        c.int[15], c.bool = number, 1
        c.until(lambda m: m.bool & 1)
        assert (c.last.int[14], c.last.int[15], c.last.int[13]) == (number, code, count + 1), c.last.int
        c.int[15], c.bool = 0, 0
        c.until(lambda m: not m.bool & 1)

    command(7, 105)
    assert c.last.control == 3
    command(1, 100)
    c.until(lambda m: m.state == CMDMODE)
    c.move()
    command(2, 101)
    assert c.last.state == MON and c.last.power == 0x7F
    command(99, 0)
    c.drain()
    assert c.end(0, interrupt=False)["because"] == "the client asked for the end"


def idle_brakes(colift):
    """Nothing moves: the brakes close. friStart opens them, unless only a motion does."""
    for options, opens in (((), True), (("--brakes-need-motion",), False)):
        c = Client(colift, "stanford", "--idle-s", "1", *options)
        c.until(lambda m: m.power == 0, 20.0)
        assert c.last.state == MON and c.last.error == 0
        c.int[14], c.int[15] = 30, 10
        c.until(lambda m: m.int[15] == 20, 20.0)
        assert (c.last.state == CMDMODE) == opens, c.last.state
        if opens:
            c.until(lambda m: m.power == 0x7F)
            c.move()
        c.end(0)
        assert opens or "no motion opened them" in c.told, c.told


def commanding(colift):
    c = Client(colift, "stanford")
    c.int[14], c.int[15] = 30, 10
    c.until(lambda m: m.state == CMDMODE and m.power)
    return c


def flags_changed(colift):
    c = commanding(colift)
    c.flags = 0x01
    c.until(lambda m: m.state == MON, 1.0)
    c.until(lambda m: m.power == 0, 1.0)
    report = c.end(1)
    assert rules(report) == ["flags-changed"], report
    assert "cmdFlags changed during cmd mode" in c.told


def big_step(colift):
    c = commanding(colift)
    c.q = list(c.last.total)
    c.q[2] += 0.02
    c.until(lambda m: m.state == MON, 1.0)
    report = c.end(1)
    assert rules(report) == ["step-too-large"], report
    assert "joint A3 asked for a step of 0.0200 rad (limit 0.0112 rad)" in c.told, c.told


def missing_answers(colift):
    c = commanding(colift)
    while c.last.state == CMDMODE:
        assert c.receive()
    c.until(lambda m: m.power == 0, 1.0)
    report = c.end(1)
    assert rules(report) == ["missed-answers"], report


def wrong_start(colift):
    c = Client(colift, "stanford")
    c.tau[3] = 2.0
    c.int[14], c.int[15] = 30, 10
    c.until(lambda m: m.int[15] == 20)
    assert c.last.state == MON
    report = c.end(1)
    assert rules(report) == ["torque-not-initialised"], report
    assert "cmd.addJntTrq not properly initialized: joint A4 starts with 2.00 N m" in c.told


def real_time(colift):
    c = Client(colift, "colift", speed=1)
    c.until(lambda m: m.send >= 10)
    began, first = time.monotonic(), c.last
    c.until(lambda m: m.send >= first.send + 200)
    lasted, cycles = time.monotonic() - began, c.last.send - first.send
    # late it may be on a busy machine, early never (by more than the first one was late)
    assert lasted > 0.004 * cycles - 0.05, (lasted, cycles)
    assert abs(c.last.time - first.time - 0.004 * cycles) < 1e-4
    c.end(0)


def only_this_machine(colift):
    """With a client on this machine nobody else reaches the emulated controller; a long datagram is reported with its true size."""
    c = Client(colift, "stanford")
    c.turns(3)
    with open("/proc/net/udp") as table:
        bound = [line.split()[1] for line in table][1:]
    here = [address for address in bound if int(address.split(":")[1], 16) == c.peer[1]]
    assert here == ["0100007F:%04X" % c.peer[1]], here
    c.socket.sendto(bytes(1400), c.peer)
    c.turns(3)
    assert rules(c.end(1)) == ["bad-datagram"] and "1400 bytes, expected 376" in c.told, c.told


def bad_options(colift):
    for options, part in ((["--cycle-ms", "2.5"], "whole milliseconds"), (["--script", "x"], "there are colift, stanford"),
                          (["--fault", "1:lost"], "is no fault of the arm"), (["--plant", "steel"], "mujoco or light"),
                          (["--to", "nowhere"], "expected IPV4:PORT"), (["--speed", "-1"], "--speed")):
        done = subprocess.run([colift, "emulate", "krc", *options], capture_output=True, text=True,
                              timeout=10)
        assert done.returncode == 2 and part in done.stderr and done.stdout == "", (options, done)


TESTS = (offsets, stanford, tum, vendor, colift_program, cep, openkc, idle_brakes, flags_changed, big_step, missing_answers, wrong_start,
         real_time, only_this_machine, bad_options)


def main():
    colift, names = sys.argv[1], sys.argv[2:]
    failed = 0
    for test in TESTS:
        if names and test.__name__ not in names:
            continue
        began = time.monotonic()
        try:
            test(colift)
            print(f"ok      {test.__name__} ({time.monotonic() - began:.1f} s)", flush=True)
        except Exception as e:  # the next test has its own emulator
            failed += 1
            print(f"FAILED  {test.__name__}: {type(e).__name__}: {e}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
