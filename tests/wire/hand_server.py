"""The far end of the hand's wire: a socketcand gateway with four pucks behind it, as a simple machine in real time, and the
program under test as a child.

Standard library only, and nothing of CoLift's own code: identifiers, frames, values and the order of waking are those of
the published property protocol. What a test wants to happen is tied to what a puck does (when()), never to a clock, and
everything that passed the gateway is kept in its order (log), so that a test can say what was sent after what was told.
"""

import collections
import copy
import heapq
import json
import os
import re
import select
import socket
import subprocess
import tempfile
import threading
import time

from pucks import (ACCEL, ASLEEP, CMD, CT, CTS, DP, DS, E, ERROR, FINGERS, FULL, GROUP, GRPA, GRPB, GRPC, HI, HOLD,
                   HSG, ID, IDLE, IHIT, IMOTOR, IVEL, JP, KD, KI, KP, LSG, M, MCV, MODE, MOV, MT, MV, NAMES,
                   OF_MONITOR, OT, OTEMP, P, PID, PIDX, POSITIONS, PUCKS, READY, RESET, ROLE, SETTABLE, SG, SN,
                   SPREAD, STAT, T, TACT, TACTID, TEMP, THERM, TRAPEZOID, TSTOP, UPSECS, V, VALUES, VBUS, VERS, WIDE,
                   WRITE_ONLY)

STOP = 199_111  # a finger's mechanical end, counts
UNITS_PER_NM = 2900.0  # of this machine's motors, at the fingertip; the program's own default
STIFFNESS = 0.5  # units for each count into what is touched
BOOT_S, HI_S = 0.9, 0.6  # silence
TIMEOUT_S = 40.0

Done = collections.namedtuple("Done", "code said document")
Frame = collections.namedtuple("Frame", "sent id data")  # sent: by the program; of an event id is None and data its name


def strain(units):
    """The gauge's twelve bits for a motor's torque, by the curve of the maker's Python client."""
    def nm(x):
        return 2.754e-10 * x ** 3 - 1.708e-6 * x ** 2 + 0.003764 * x - 2.85

    low, high, wanted = 2000, 4095, nm(2000) + units / UNITS_PER_NM
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if nm(middle) < wanted else (low, middle)
    return high if units > 0 else 2000


class Puck:
    def __init__(self, node, start, tactile):
        self.node, self.finger = node, node != SPREAD
        self.role = (0x1E05 if self.finger else 0x1605) & ~(0 if tactile else 0x1000)
        self.true = float(start)  # counts from the open stop
        self.meets = None  # where something is in its way
        self.power_on = time.monotonic()
        self.silent_until = 0.0
        self.dead = False
        self.hi_after = None
        self.reset()

    def reset(self):
        """As after switching on: flash values, and zero is where it stands."""
        self.v = {VERS: 200, ROLE: self.role, SN: 3000 + self.node, ID: self.node, ERROR: 0, STAT: ASLEEP, MODE: IDLE, TEMP: 35,
                  OTEMP: 60, THERM: 30, VBUS: 48, IMOTOR: 2048, GRPA: 0, GRPB: 7, GRPC: 5, MT: 2200, V: 0, MCV: 200,
                  MOV: 200, MV: 200 if self.finger else 50, DP: 45000 if self.finger else 17975, E: 0, OT: 0,
                  CT: 195000 if self.finger else 35950, DS: 25600, CTS: 4096, PIDX: self.node - 10, HSG: 0, LSG: 0, IVEL: -75,
                  HOLD: int(not self.finger), TSTOP: 50 if self.finger else 150, KP: 500, KD: 2500, KI: 0, ACCEL: 200,
                  TACT: 0, TACTID: 3, IHIT: 1700}
        self.offset, self.joint_offset = self.true, self.true / 2.5
        self.still_ms, self.hi_after = 0.0, None
        self.derate_by = TEMP

    def torque_limit(self):
        """Units, faded by heat: from OTEMP - 16 down to none at OTEMP."""
        return self.v[MT] * min(1.0, max(0.0, (self.v[OTEMP] - self.v[self.derate_by]) / 16))

    def load(self):
        return 0.0 if self.meets is None else max(0.0, (self.true - self.meets) * STIFFNESS)

    def counts(self):
        return int(round(self.true - self.offset))

    def joint(self):
        return int(round(self.true / 2.5 - self.joint_offset))

    def get(self, what):
        if what == SG:
            return strain(self.load()) if self.finger else 2000
        if what == UPSECS:
            return int(time.monotonic() - self.power_on)
        if what == T:
            return int(min(self.load(), self.torque_limit())) if self.v[MODE] == TRAPEZOID else 0
        if what == JP:
            return self.joint()
        return None if what in WRITE_ONLY else self.v.get(what)

    def step(self, ms, now):
        if self.hi_after is not None and now >= self.silent_until and now >= self.hi_after:
            self.true, self.offset, self.joint_offset, self.v[E] = 0.0, 0.0, 0.0, 0
            self.hi_after = None
            self.stopped()
        if self.v[MODE] != TRAPEZOID or self.v[STAT] != READY or self.hi_after is not None:
            return
        way = self.v[E] + self.offset - self.true
        before = self.true
        self.true += max(-self.v[MV] * ms, min(self.v[MV] * ms, way))
        most = STOP if self.finger else 36_000
        if self.meets is not None:
            most = max(before, min(most, self.meets + self.torque_limit() / STIFFNESS))
        self.true = min(max(self.true, 0.0), most)
        self.still_ms = 0.0 if abs(self.true - before) > 0.5 else self.still_ms + ms
        strained = 0 < self.v[HSG] < 10000 and way > 0 and self.get(SG) > self.v[HSG]
        if abs(way) < 0.5 or strained or 0 < self.v[TSTOP] <= self.still_ms:
            self.stopped()

    def stopped(self):
        self.v[MODE] = PID if self.v[HOLD] else IDLE


class Hand:
    """The gateway's thread. Hold `lock` to touch a puck from another."""

    longest_pause = 0.0  # of all hands: this machine's fault, not the program's
    MAX_PAUSE, UNIT = 0.02, "s"

    def __init__(self, tactile=False, start=(20000, 30000, 10000, 4000)):
        self.listening = socket.socket()
        self.listening.bind(("127.0.0.1", 0))
        self.port = self.listening.getsockname()[1]
        self.listening.listen(4)
        self.lock = threading.Condition(threading.RLock())
        self.pucks = {node: Puck(node, at, tactile) for node, at in zip(PUCKS, start)}
        self.log, self.broken, self.watches = [], [], []
        self.client, self.buffer, self.raw = None, b"", False
        self.out, self.serial, self.last_due = [], 0, 0.0
        self.greeting = b"< hi >"
        self.delay = lambda: 0.0  # s, of an answer; answers keep their order
        self.copies = (0.0,)  # s after that, each one more time
        self.noise = None  # bytes before each frame
        self.frozen = False  # the pucks' time stands still
        self.ended, self.fault, self.forgiven = False, None, None
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()

    @staticmethod
    def end_program():
        Program.last.kill()
        Program.last.communicate()

    def __enter__(self):
        return self

    def __exit__(self, failed, *_):
        """What the program may never do is judged here, of every session."""
        self.ended = True
        self.thread.join(TIMEOUT_S)
        for s in (self.client, self.listening):
            if s:
                s.close()
        bad = [b for b in self.broken if not self.forgiven or self.forgiven not in b]
        assert failed or not bad and not self.fault, (bad, self.fault)

    def __getitem__(self, node):
        return self.pucks[node]

    def fingers(self):
        return [self.pucks[f] for f in FINGERS]

    def state(self):
        """All that a hand keeps while no program is connected."""
        with self.lock:
            return {n: copy.deepcopy(p.__dict__) for n, p in self.pucks.items()}

    def set_state(self, state):
        with self.lock:
            for node, values in state.items():
                self.pucks[node].__dict__.update(copy.deepcopy(values))

    # what happens

    def when(self, ready, then, name):
        """Once, when ready() is first true: then(), and `name` in the log."""
        with self.lock:
            self.watches.append((ready, then, name))

    def until(self, ready, what):
        with self.lock:
            assert self.lock.wait_for(lambda: ready() or self.fault, TIMEOUT_S), f"never: {what}"
            assert not self.fault, self.fault

    def hang_up(self, for_good):
        if self.client:
            self.client.close()
        self.client = None
        if for_good:
            self.listening.close()
            self.listening = None

    def foreign(self, sender, to, what, value):
        """Another node's setting: the pucks take it, and the gateway forwards its frame as any other."""
        data = self.setting(what, value)
        self.emit(sender << 5 | to, data)
        self._frame(to, data)

    # the wire

    def setting(self, what, value):
        size = 4 if what in WIDE else 2
        return bytes([0x80 | what, 0]) + (value & (1 << 8 * size) - 1).to_bytes(size, "little")

    def emit(self, identifier, data):
        now = time.monotonic()
        self.last_due = max(self.last_due, now + self.delay())
        for more in self.copies:
            self.serial += 1
            heapq.heappush(self.out, (self.last_due + more, self.serial, identifier, bytes(data)))

    def _flush(self, now):
        while self.out and self.out[0][0] <= now:
            _, _, identifier, data = heapq.heappop(self.out)
            text = f"< frame {identifier:03X} {now:.6f} {data.hex().upper()} >".encode()
            if self.client:
                self.log.append(Frame(False, identifier, data))
                self._send((self.noise() if self.noise else b"") + text)

    def _send(self, data):
        try:
            self.client.sendall(data)
        except OSError:
            self.client = None

    def _run(self):
        try:
            last = time.monotonic()
            while not self.ended:
                wait = 0.001 if self.client else 0.005
                asked = time.monotonic()
                sources = [s for s in (self.listening, self.client) if s]
                ready = select.select(sources, [], [], wait)[0] if sources else time.sleep(wait) or []
                now = time.monotonic()
                if self.client:
                    Hand.longest_pause = max(Hand.longest_pause, now - asked - wait, now - last - wait)
                with self.lock:
                    if not self.frozen:
                        for puck in self.pucks.values():
                            puck.step(1e3 * (now - last), now)
                    last = now
                    self._watch()
                    if self.listening in ready and self.listening:
                        self._accept()
                    elif self.client in ready and self.client:
                        self._read()
                    self._flush(time.monotonic())
                    self.lock.notify_all()
        except Exception as e:  # told by whoever waits, and at the end
            with self.lock:
                self.fault = f"the hand's own fault: {type(e).__name__}: {e}"
                self.lock.notify_all()

    def _watch(self):
        for watch in [w for w in self.watches if w[0]()]:
            self.watches.remove(watch)
            self.log.append(Frame(False, None, watch[2]))
            watch[1]()

    def _accept(self):
        self.client, _ = self.listening.accept()
        self.client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.buffer, self.raw, self.out = b"", False, []
        self._send(self.greeting)

    def _read(self):
        try:
            data = self.client.recv(65536)
        except OSError:
            data = b""
        if not data:
            self.client = None
            return
        self.buffer += data
        while self.client and (found := re.match(rb"\s*<([^<>]*)>", self.buffer)):
            self.buffer = self.buffer[found.end():]
            self._command(found[1].decode().split())

    def _command(self, words):
        if words[0] == "open":
            assert words[1:] == ["can0"], words
            self._send(b"< ok >")
        elif words[0] == "rawmode":
            self.raw = True
            self._send(b"< ok >")
        else:
            assert words[0] == "send" and self.raw and len(words[1]) == 3, words
            data = bytes(int(b, 16) for b in words[3:])
            assert len(data) == int(words[2], 16), words
            identifier = int(words[1], 16)
            self.log.append(Frame(True, identifier, data))
            if identifier >> 5 & 31:
                self.broken.append(f"sent as node {identifier >> 5 & 31}")
            self._frame(identifier, data)
            self._watch()

    # the pucks

    def members(self, identifier):
        to = identifier & 31
        if not identifier & GROUP:
            return [p for p in self.pucks.values() if p.node == to]
        return [p for p in self.pucks.values() if to in (p.v[GRPA], p.v[GRPB], p.v[GRPC])]

    def _frame(self, identifier, data):
        now, alive = time.monotonic(), [p for p in self.pucks.values() if not p.dead]
        if alive and all(p.silent_until > now for p in alive):
            self.broken.append(f"{identifier:03X} {data.hex()}: nobody acknowledges now, the bus would go off")
        for puck in self.members(identifier):
            if puck.silent_until > now or puck.dead or not data:
                continue
            what = data[0] & 0x7F
            if not data[0] & 0x80:
                self._answer(puck, what, len(data))
            elif len(data) in (4, 6) and data[1] == 0:
                self._set(puck, what, int.from_bytes(data[2:], "little", signed=True), now)
            else:
                self.broken.append(f"a setting {data.hex()}")

    def _answer(self, puck, what, size):
        if size > 2:
            self.broken.append(f"a question of {size} bytes")
        if puck.v[STAT] == ASLEEP and what not in OF_MONITOR:
            return
        if what == P:
            pack = lambda n: (0x800000 | n & 0x3FFFFF).to_bytes(3, "big")
            self.emit(GROUP | puck.node << 5 | POSITIONS, pack(puck.counts()) + (pack(puck.joint()) if puck.finger else b""))
        elif what == TACT:
            self._scan(puck)
        elif (value := puck.get(what)) is not None:
            self.emit(GROUP | puck.node << 5 | VALUES, self.setting(what, value))
        else:
            self.broken.append(f"a question about {what}")

    def _scan(self, puck):
        """Five frames with five cells of twelve bits each; the middle of the pad bears what the finger presses."""
        if puck.v[TACT] != 2 or not puck.role & 0x1000:
            return
        cells = [0] * 25
        cells[6:12] = [min(4095, int(puck.load()))] * 6
        for n in range(5):
            text = f"{n:X}" + "".join(f"{c:03X}" for c in cells[5 * n:5 * n + 5])
            self.emit(GROUP | puck.node << 5 | FULL, bytes.fromhex(text))

    def _set(self, puck, what, value, now):
        if what not in SETTABLE:
            self.broken.append(f"sets property {what} to {value}")
            return
        if puck.v[STAT] == ASLEEP:
            if what != STAT:
                self.broken.append(f"sets property {what} of the sleeping {NAMES[puck.node]}")
            elif value == READY:
                puck.silent_until = now + BOOT_S
                puck.v[STAT] = READY
        elif what == CMD and value == HI:
            way = puck.true / -puck.v[IVEL] * 1e-3
            puck.silent_until, puck.hi_after, puck.v[MODE] = now + HI_S, now + max(HI_S, way), TRAPEZOID
        elif what == CMD and value == RESET:
            puck.reset()
        elif what in (CMD, M, P, T) or what == MODE and value not in (IDLE, PID, TRAPEZOID):
            self.broken.append(f"{NAMES[puck.node]}: {what} = {value}, which this hand's program has no use for")
        else:
            puck.v[what] = value
            if what == MODE:
                puck.still_ms = 0.0
            if what == TACT:  # 0 and 3 (a tare: this pad shows nothing without load) are not answered
                self._scan(puck)

    # what was sent after a fault

    def commands_after(self, name, told=None, times=1, live=None, allow=lambda pucks, what, value: False):
        """Commands for motors after `name` had been told to the program: `told(frame)` `times` times, then three
        questions about P that reach `live`. The program reads all that has come before it sends anything: the third was
        sent after what was told was read. Without told(): all commands after `name`."""
        with self.lock:
            log = list(self.log)
        begin = next(i for i, f in enumerate(log) if f.id is None and f.data == name)
        left, polls, found = (times, 0, []) if told else (0, 3, [])
        for f in log[begin:]:
            if f.id is None:
                continue
            if left:
                left -= bool(told(f))
                continue
            if not f.sent:
                continue
            to = [p.node for p in self.members(f.id)]
            if polls < 3:
                polls += f.data == bytes([P]) and (live is None or live in to)
            elif f.data[0] & 0x80:
                what, value = f.data[0] & 0x7F, int.from_bytes(f.data[2:], "little", signed=True)
                if (what in (P, DP, E, M, T, V, MT, CMD) or what == MODE and value) and not allow(to, what, value):
                    found.append((to, what, value))
        assert not left, f"{name} was not told to the program"
        return found


class Program:
    """`colift hal hand VERB` at this hand; `more`: of the driver's settings."""

    last = None

    def __init__(self, colift, hand, verb, *options, more="", as_text=False):
        self.folder, self.as_text = tempfile.TemporaryDirectory(), as_text
        rig = os.path.join(self.folder.name, "rig.yaml")
        with open(rig, "w") as f:
            f.write(f"arm: fri\nhand: barrett\nemulator: never\n"
                    f"barrett: {{can: 'socketcand:127.0.0.1:{hand.port}/can0'{more}}}\n")
        self.process = subprocess.Popen([colift, "hal", "hand", verb, *options, "--robot", rig] + ["--json"] * (not as_text),
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        Program.last = self.process

    def end(self, code):
        """With this exit code, or any (None)."""
        out, err = self.process.communicate(timeout=TIMEOUT_S)
        self.folder.cleanup()
        assert code in (None, self.process.returncode), f"exit code {self.process.returncode}, expected {code}: {out + err}"
        return Done(self.process.returncode, out + err, json.loads(out) if out and not self.as_text else None)


def run(colift, hand, code, verb, *options, **how):
    return Program(colift, hand, verb, *options, **how).end(code)
