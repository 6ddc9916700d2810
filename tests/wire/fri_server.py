"""The far end of the arm's wire, as a KRC with one of the KRL programs of the field.

Standard library only, and nothing of CoLift's own code: every field is packed at its published byte offset (916 and
376 bytes, little endian, IEEE 754 single). A measurement is sent when the one before is answered, so a busy machine
makes a test slower and not red.
"""

import json
import os
import select
import signal
import socket
import struct
import subprocess
import tempfile
import time

MON, CMD = 1, 2
PERIOD = 0.012  # three lost ones are still within what the program takes for one motion
BENT = [0.1, 0.6, -0.2, -1.3, 0.3, 0.9, -0.4]


def single(x):
    return struct.unpack("<f", struct.pack("<f", x))[0]


class Answer:
    def __init__(self, data):
        assert len(data) == 376, f"an answer of {len(data)} bytes"
        at = lambda form, offset: struct.unpack_from("<" + form, data, offset)
        self.send, self.reflected, size, ident = at("4H", 0)
        assert (size, ident) == (376, 0x1005), (size, hex(ident))
        self.real, self.int = at("16f", 8), at("16i", 72)
        self.bool, fill = at("2H", 136)
        assert fill == 0
        (self.flags,) = at("I", 140)
        self.q, self.frame, self.tau, self.wrench = at("7f", 144), at("12f", 172), at("7f", 220), at("6f", 248)
        self.stiffness, self.damping = at("7f", 272), at("7f", 300)


class Krc:
    """The controller, and the program under test as a child. turn() is one cycle: a measurement out, its answer in."""

    longest_pause = 0.0  # in periods between two measurements, of all controllers: this machine's fault, not the program's
    MAX_PAUSE, UNIT = 4, "periods"

    def __init__(self, colift, *arguments, script="stanford", control=3, krc="127.0.0.1", more="", period=PERIOD,
                 first_s=30, json=True):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        port = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        port.bind(("127.0.0.1", 0))
        self.pc = ("127.0.0.1", port.getsockname()[1])
        port.close()
        self.folder = tempfile.TemporaryDirectory()
        rig = os.path.join(self.folder.name, "rig.yaml")
        with open(rig, "w") as f:
            f.write(f"arm: fri\nemulator: never\nfri: {{address: 127.0.0.1, port: {self.pc[1]}, "
                    f"krc: '{krc}', cycle_ms: {1e3 * period:g}, script: {script}, first_s: {first_s}{more}}}\n")
        # a SIGHUP that is ignored (nohup) would be handed on, and stays ignored there
        self.process = subprocess.Popen([colift, "hal", "arm", *arguments, "--robot", rig, *["--json"] * json],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
        Krc.last = self
        # what stands in the measurement
        self.period = self.claimed = period  # as it is, and as the measurement says
        self.send, self.reflected, self.clock = 0, 0, 12.0
        self.real, self.int, self.bool = [0.0] * 16, [0] * 16, 0
        self.state, self.quality, self.control = MON, 3, control
        self.power, self.error, self.warning = 0x7F, 0, 0
        self.celsius = [30.0] * 7
        self.krl, self.fri = list(BENT), [0.0] * 7
        self.sag = [0.0] * 7  # measured minus commanded
        self.tau, self.external, self.wrench = [0.0] * 7, [0.0] * 7, [0.0] * 6
        # what came
        self.answers = []
        self.answered = {}  # by measurement, how often
        self.flags = None
        self.script = script
        self.starts, self.strategies = 0, []
        self.switches = False  # takes the strategy that it is told
        self.stays_in_monitor = ()  # for these strategies
        self.begun = False
        self.follows = True
        self.paced = False  # no measurement sooner than a period after the one before
        self.sent_at = 0.0

    @staticmethod
    def end_program():
        Krc.last.process.kill()
        Krc.last.process.communicate()

    @property
    def total(self):
        return [single(single(a) + single(b)) for a, b in zip(self.krl, self.fri)]

    @property
    def measured(self):
        return [single(a + b) for a, b in zip(self.total, self.sag)]

    def measurement(self):
        b = bytearray(916)
        put = lambda offset, form, *values: struct.pack_into("<" + form, b, offset, *values)
        put(0, "4H", self.send, self.reflected, 916, 0x2006)
        put(8, "16f", *self.real)
        put(72, "16i", *self.int)
        put(136, "H", self.bool)
        put(140, "f", self.clock)
        put(144, "H", self.state)
        put(146, "H", self.quality)
        put(148, "f", self.claimed)
        put(152, "f", self.claimed)
        put(156, "f", 1.0)
        put(160, "f", 0.995)
        put(164, "f", 0.0005)
        put(168, "f", 0.0001)
        put(172, "f", 0.005)
        put(176, "I", 3)
        put(180, "4H", self.power, self.control, self.error, self.warning)
        put(188, "7f", *self.celsius)
        put(216, "7f", *self.measured)
        for frame in (244, 348):
            put(frame, "12f", 1, 0, 0, 0.5, 0, 1, 0, 0.1, 0, 0, 1, 0.4)
        put(292, "7f", *self.krl)
        put(320, "7f", *self.fri)
        put(396, "12f", 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0)
        put(444, "7f", *self.tau)
        put(472, "7f", *self.external)
        put(500, "6f", *self.wrench)
        put(524, "42f", *([0.1] * 42))
        put(692, "49f", *([float(i % 8 == 0) for i in range(49)]))
        put(888, "7f", *([0.5] * 7))
        return b

    def out(self, data, sender=None):
        (sender or self.socket).sendto(data, self.pc)

    def next(self):
        """Counts on; what the KRL program does meanwhile."""
        self.send = (self.send + 1) % 65536
        self.clock += self.period

    def emit(self):
        """The next measurement goes out."""
        self.next()
        self.out(self.measurement())
        now = time.monotonic()
        if self.answers:
            Krc.longest_pause = max(Krc.longest_pause, (now - self.sent_at) / self.period)
        self.sent_at = now

    def collect(self, patience):
        """The next answer, or None; every answer is judged."""
        if not select.select([self.socket], [], [], patience)[0]:
            return None
        data, sender = self.socket.recvfrom(2000)
        assert sender == self.pc, sender
        a = Answer(data)
        before = self.answers[-1] if self.answers else None
        if before:
            assert a.send == (before.send + 1) % 65536, f"answer {a.send} after {before.send}"
            assert a.flags == before.flags or self.state != CMD, "cmdFlags changed in command mode"
        self.answered[a.reflected] = self.answered.get(a.reflected, 0) + 1
        assert self.answered[a.reflected] == 1, f"measurement {a.reflected} was answered twice"
        self.answers.append(a)
        return a

    def turn(self, patience=2.0):
        """One cycle; the answer, None when the program has ended or said nothing."""
        if self.paced:
            self.await_period()
        self.emit()
        began = self.sent_at
        # until the program has its socket nobody hears
        while time.monotonic() - began < (patience if self.answers else 0.02):
            a = self.collect(0.02)
            if a:
                self.take(a)
                return a
            if self.process.poll() is not None:
                return None
        return None

    def await_period(self):
        """Until the next measurement is due by this controller's own clock."""
        left = self.sent_at + self.period - time.monotonic()
        if left > 0:
            time.sleep(left)

    def take(self, a):
        assert a.reflected == self.send, f"answered {a.reflected} instead of {self.send}"
        self.reflected = a.send
        mirrored = self.state != CMD or self.power != 0x7F
        if mirrored:
            assert list(a.q) == self.total, "not mirrored bit by bit"
            assert not any(a.tau) and not any(a.wrench), "torque although nothing may be commanded"
        elif self.follows:
            step = max(abs(x - y) for x, y in zip(a.q, self.total))
            assert step <= 1.8 * self.period, f"a step of {step} rad"
            self.fri = [single(x - y) for x, y in zip(a.q, self.krl)]
        self.program(a)

    def program(self, a):
        """One round in each 50 ms."""
        if self.script == "vendor":
            quiet = self.starts and self.state == MON  # at the end the words are cleared
            assert a.real[0] == self.real[1] or quiet, f"mirrored {a.real[0]} instead of {self.real[1]}"
            self.real[1] = single(self.real[1] + 0.25)
        if self.send % 4 == 0:
            getattr(self, self.script)(a)

    def none(self, a):
        """A person at the panel, once the connection is good for a while."""
        if len(self.answers) >= 120 and not self.starts:
            self.state, self.starts = CMD, 1

    def vendor(self, a):
        if a.int[0] == 10 and self.state == MON:
            self.state, self.starts = CMD, self.starts + 1
        elif a.int[0] == 1:
            self.state = MON

    def tum(self, a):
        if a.bool & 1 and not self.bool & 1:
            self.bool |= 1
            self.state = {1: CMD, 2: MON}.get(a.int[0], self.state)
            self.starts += a.int[0] == 1
        elif not a.bool & 1:
            self.bool &= ~1

    def stanford(self, a):
        self.int[14] = 30
        self.int[15] = self.int[15] or 10
        if a.int[15] == 10 and self.int[15] != 20:
            if self.switches and self.control != a.int[14] // 10:
                self.control = a.int[14] // 10
                return
            assert self.switches or a.int[14] == 30, f"strategy {a.int[14]}"
            self.int[15] = 20
            self.start(a, a.int[14])
        if a.int[15] == 20 and self.int[15] != 10:
            self.state, self.int[15] = MON, 10

    def cep(self, a):
        """The Centro Piaggio's: its first start is in position control, whatever it is asked for."""
        if not self.begun:
            self.begun, self.int[1], self.control = True, 10, 1
        elif a.int[1] == 1 and self.int[1] != 1:
            strategy = 10 if self.int[1] == 10 else a.int[0]
            if self.control != strategy // 10:
                self.control = strategy // 10  # on the wire a round before friStart
                return
            self.start(a, strategy)
            self.int[1] = 1
        elif a.int[1] == 0 and self.int[1] == 1:
            self.state, self.int[1] = MON, 0

    def openkc(self, a):
        """OpenKC's: a command with a bit, answered by its number and a bit."""
        if self.bool & 1:
            self.bool &= a.bool
        elif a.bool & 1:
            command = a.int[15]
            if command in (6, 7, 9):
                self.control = {6: 2, 7: 3, 9: 1}[command]
            elif command == 1:
                self.start(a, 10 * self.control)
            elif command == 2:
                self.state = MON
            self.int[14], self.bool = command, self.bool | 1
            self.int[13] += 1

    def start(self, a, strategy):
        """friStart, as far as the flags of the answer let it."""
        assert a.flags == {10: 0x1, 20: 0x3500, 30: 0x35}[strategy], (hex(a.flags), strategy)
        self.starts += 1
        self.strategies.append(strategy)
        if strategy not in self.stays_in_monitor and self.quality >= 2 and not self.error:
            self.state = CMD

    def until(self, done, seconds=30.0):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            a = self.turn()
            if a and done(a):
                return a
            if self.process.poll() is not None:
                break
        raise AssertionError(f"did not happen; {self.process.poll()} {len(self.answers)} answers")

    def turns(self, n):
        for _ in range(n):
            assert self.turn(), f"no answer to {self.send}"

    def commanding(self):
        self.until(lambda a: self.state == CMD)
        self.turns(10)

    def finish(self, code):
        """Goes on until the program ends; its document."""
        end = time.monotonic() + 90
        while self.process.poll() is None:
            assert time.monotonic() < end, "the program does not end"
            self.turn()
        out, err = self.process.communicate(timeout=10)
        self.socket.close()
        self.folder.cleanup()
        assert self.process.returncode == code, (self.process.returncode, code, err)
        self.told = err
        return json.loads(out)
