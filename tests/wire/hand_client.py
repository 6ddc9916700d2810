"""The hand's bus as a client on Debian's python-can sees it: frames of the pucks, and `colift emulate hand` as a child.

Nothing of CoLift's own code. Identifiers: bit 10 group, bits 9 to 5 from, bits 4 to 0 to. A question is one byte, the
property; a setting [0x80 | property, 0, value, little endian]. Times only bound how long something is waited for.
"""

import json
import logging
import re
import signal
import subprocess
import threading
import time

import can

from pucks import (ALL, CMD, E, F1, F2, F3, FINGERS, FULL, GROUP, HI, IDLE, MODE, P, PID, POSITIONS, PUCKS, SPREAD,
                   STAT, TACT, TRAPEZOID, VALUES, WIDE)

# its parser warns of the newline after each frame, which it needs
logging.getLogger("can.interfaces.socketcand").setLevel(logging.ERROR)

TIMEOUT_S = 30.0  # s, for an answer or the end of a move; reached only when it fails


def signed(value, bits):
    return value - (1 << bits) if value >> bits - 1 else value


def counts(data):
    """A packed position: 22 bits, big endian."""
    assert len(data) == 3, data.hex()
    assert data[0] & 0xC0 == 0x80, f"marker of {data.hex()}"
    return signed(int.from_bytes(data, "big") & 0x3FFFFF, 22)


def packed(data):
    """Motor and, for a finger, joint."""
    return counts(data[:3]), counts(data[3:]) if len(data) > 3 else None


assert packed(bytes.fromhex("82F9B88130B0")) == (195000, 78000) and packed(bytes.fromhex("808C70")) == (35952, None)
assert counts(bytes.fromhex("BFFFFE")) == -2


def cells(frame):
    """Number of a frame of the full scan, and its five values of 12 bits."""
    digits = frame.data.hex()
    assert len(digits) == 16, digits
    return int(digits[0], 16), [int(digits[i:i + 3], 16) for i in range(1, 16, 3)]


def top_ten(frame):
    """Cell (from 0) to whole N/cm2, of the other format."""
    assert frame.dlc == 8, frame
    bits = int.from_bytes(frame.data[:3], "big")
    touched = [c for c in range(24) if bits >> c & 1]
    values = [int(d, 16) for d in frame.data[3:].hex()]
    assert len(touched) == 10, frame
    return dict(zip(touched, values))


class Emulator:
    """`colift emulate hand` until end(); its events are lines."""

    def __init__(self, colift, bus, *options):
        self.process = subprocess.Popen([colift, "emulate", "hand", "--bus", bus, "--plant", "light", "--json", *options],
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines, self.news = [], threading.Condition()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()
        self.ready = self.wait_for("ready: hand on ")

    def _read(self):
        for line in self.process.stderr:
            with self.news:
                self.lines.append(line.strip())
                self.news.notify_all()
        with self.news:
            self.lines.append(None)
            self.news.notify_all()

    def wait_for(self, part, times=1):
        """The line in which `part` stands for the nth time."""
        def found():
            return [line for line in self.lines if line and part in line]

        with self.news:
            self.news.wait_for(lambda: len(found()) >= times or None in self.lines, TIMEOUT_S)
            assert len(found()) >= times, f"no \"{part}\" in {self.lines}"
            return found()[times - 1]

    def end(self, code=0):
        """Its report; `code` 1 when a rule was broken."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        report = json.loads(self.process.stdout.read())
        assert self.process.wait(TIMEOUT_S) == code, (self.process.returncode, report)
        assert report["schema"] == "colift.emulate/1" and report["device"] == "hand"
        return report

    def kill(self):
        self.process.kill()
        self.process.wait()


class Client:
    """A node on the emulator's bus."""

    def __init__(self, colift, bus, *options):
        """`bus`: "socketcand" (loopback, any port), or "socketcan:FAR[,NEAR]"."""
        kind, _, names = bus.partition(":")
        far, _, near = names.partition(",")
        self.emulator = Emulator(colift, f"{kind}:{far or '127.0.0.1:0/can0'}", *options)
        if kind == "socketcand":
            port = int(re.search(r"port (\d+)", self.emulator.ready)[1])
            self.bus = can.interface.Bus(interface="socketcand", host="127.0.0.1", port=port, channel="can0")
        else:
            self.bus = can.interface.Bus(interface="socketcan", channel=near or far)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.bus.shutdown()
        self.emulator.kill()

    def send(self, identifier, data):
        self.bus.send(can.Message(arbitration_id=identifier, data=bytes(data), is_extended_id=False))

    def next(self, patience=TIMEOUT_S):
        return self.bus.recv(patience)

    def expect(self, identifier):
        """The next frame, and nothing else in between."""
        frame = self.next()
        assert frame, f"{identifier:03X} did not come"
        assert frame.arbitration_id == identifier, f"{frame} instead of {identifier:03X}"
        return frame

    def nothing_more(self, puck=F1):
        """What was sent before is not answered: the answer to a question after it comes first."""
        assert self.ask(puck, STAT) in (0, 2)

    # one puck, from node 0

    def ask(self, puck, what):
        self.send(puck, [what])
        frame = self.expect(GROUP | puck << 5 | VALUES)
        head, value = bytes(frame.data[:2]), frame.data[2:]
        assert head == bytes([0x80 | what, 0]), frame
        assert len(value) == (4 if what in WIDE else 2), frame
        return int.from_bytes(value, "little", signed=True)

    def position(self, puck):
        self.send(puck, [P])
        return packed(self.expect(GROUP | puck << 5 | POSITIONS).data)

    def tell(self, to, what, value, size=None):
        """A setting, as wide as the property or `size` bytes; never answered."""
        size = size or (4 if what in WIDE else 2)
        self.send(to, bytes([0x80 | what, 0]) + (value & (1 << 8 * size) - 1).to_bytes(size, "little"))

    def set(self, puck, what, value, size=None):
        self.tell(puck, what, value, size)
        assert self.ask(puck, what) == value

    def until_still(self, puck, modes=(IDLE,)):
        """Asks for its mode until it is one of these; nobody speaks unasked in between."""
        end = time.monotonic() + TIMEOUT_S
        while (mode := self.ask(puck, MODE)) not in modes:
            assert mode == TRAPEZOID, mode
            assert time.monotonic() < end, f"{puck} still moves"
            assert self.next(0.02) is None

    # whole steps

    def wake(self):
        self.tell(GROUP | ALL, STAT, 2)
        assert self.next(0.2) is None
        # a question now would find nobody who acknowledges it
        for puck in ("F1", "F2", "F3", "spread"):
            self.emulator.wait_for(f"{puck} is awake")
        for puck in PUCKS:
            assert self.ask(puck, STAT) == 2

    def wake_if_asleep(self):
        """For tests in which the zero does not matter: a hand that was left awake may yet start asleep."""
        if self.ask(F1, STAT) != 2:
            self.wake()

    def initialise(self):
        for puck in FINGERS:
            self.tell(puck, CMD, HI)
        for puck in ("F1", "F2", "F3"):
            self.emulator.wait_for(f"{puck} has found its stop")
        for puck in FINGERS:
            self.until_still(puck)
        self.tell(SPREAD, CMD, HI)
        self.emulator.wait_for("spread has found its stop")
        self.until_still(SPREAD, (PID,))

    def move(self, puck, target):
        self.set(puck, E, target)
        self.tell(puck, MODE, TRAPEZOID)
        self.until_still(puck, (PID,) if puck == SPREAD else (IDLE,))

    def full_scan(self, puck):
        """24 values in 1/256 N/cm2, from five frames in order."""
        self.tell(puck, TACT, 2)
        all_cells = []
        for number in range(5):
            counted, values = cells(self.expect(GROUP | puck << 5 | FULL))
            assert counted == number
            all_cells += values
        return all_cells[:24]
