#!/usr/bin/python3
"""Drives `colift emulate hand --plant light` with Debian's python-can, over a socketcand gateway or SocketCAN.

    hand_client_test.py COLIFT [--bus socketcand | --bus socketcan:FAR[,NEAR]] [NAME...]

The emulator is at FAR, the client at NEAR (on a virtual interface the same). Exit code 77: there is no python-can.
"""

import argparse
import sys
import time
import traceback

try:
    import can  # noqa: F401
except ImportError:
    print("SKIPPED: no python-can; tools/setup --dev installs python3-can, for /usr/bin/python3")
    sys.exit(77)

sys.dont_write_bytecode = True  # leaves nothing in the source tree
from hand_client import (Client, packed, signed, top_ten)
from pucks import (ALL, CLOSE, CMD, CT, DP, E, F1, F2, F3, FINGERS, GROUP, GRPC, HAND, HOLD, IDLE, ID, JOINTS, JP,
                   MODE, MOVE, MT, MV, OPEN, P, PID, POSITIONS, PUCKS, ROLE, SG, SPREAD, STAT, TACT, TEMP, THERM,
                   TOP_TEN, TRAPEZOID, TSTOP, VALUES, VERS)


def rules(report):
    return [r["rule"] for r in report["broken_rules"]]


def wakes(hand):
    """A hand that was just switched on tells who it is, wakes in silence, and then tells all."""
    with hand() as h:
        for puck in PUCKS:
            assert h.ask(puck, STAT) == 0 and h.ask(puck, ID) == puck and h.ask(puck, VERS) == 200
            role = h.ask(puck, ROLE)
            assert role & 0x1F == 5 and role & 0x1000 and bool(role & 0x0800) == (puck != SPREAD)
        h.wake()
        for puck in PUCKS:
            assert h.ask(puck, MODE) == IDLE and h.ask(puck, GRPC) == HAND
            assert 15 <= h.ask(puck, TEMP) < 50 and 15 <= h.ask(puck, THERM) < 50
        for puck in FINGERS:
            assert 1900 <= h.ask(puck, SG) <= 2300
        assert rules(h.emulator.end()) == []


def monitor_knows_little(hand):
    """Before it is awake a puck does not tell its mode, takes no settings, and does not move."""
    with hand() as h:
        h.send(F1, [MODE])
        h.nothing_more()
        h.tell(F1, MODE, TRAPEZOID)
        h.tell(F2, CMD, CLOSE)
        h.nothing_more()
        h.wake()
        assert h.ask(F1, MODE) == IDLE and h.position(F2) == (0, 0)
        assert rules(h.emulator.end(1)) == ["not-readable"]


def initialises_and_moves(hand):
    with hand() as h:
        h.wake()
        h.initialise()
        for puck in PUCKS:
            motor, joint = h.position(puck)
            assert abs(motor) <= 500 and (joint is None) == (puck == SPREAD)
        for puck, target in ((F1, 81487), (F2, 120000), (F3, 40000)):
            h.set(puck, MV, 200)
            h.move(puck, target)
            motor, joint = h.position(puck)
            assert abs(motor - target) <= 5, motor
            assert abs(motor - 2.5 * joint) <= 5, (motor, joint)
        for puck in FINGERS:
            h.move(puck, 0)
            assert abs(h.position(puck)[0]) <= 5
        h.set(SPREAD, MV, 50)
        h.move(SPREAD, 17975)
        assert abs(h.position(SPREAD)[0] - 17975) <= 5 and h.ask(SPREAD, HOLD) == 1
        report = h.emulator.end()
        assert rules(report) == [] and report["initialised"] == [1, 1, 1, 1], report


def moves_together(hand):
    """Goals for each, one command for all; a finger without a goal of its own goes to the factory's."""
    with hand("--awake") as h:
        h.wake_if_asleep()
        goals = {F1: 30000, F2: 50000, F3: 70000, SPREAD: 0}
        for puck, goal in goals.items():
            h.set(puck, DP, goal)
        h.tell(GROUP | HAND, CMD, MOVE, 4)
        for puck, goal in goals.items():
            h.until_still(puck, (PID,) if puck == SPREAD else (IDLE,))
            assert abs(h.position(puck)[0] - goal) <= 5
        assert rules(h.emulator.end()) == []


def holds_something(hand):
    """Closing ends at the object; strain and pads tell of it, and the joint encoder where the inner links are."""
    with hand("--awake", "--width", "0.08") as h:
        h.wake_if_asleep()
        idle = {puck: h.ask(puck, SG) for puck in FINGERS}
        for puck in FINGERS:
            h.set(puck, TSTOP, 150)
            h.set(puck, MT, 1800)
            h.tell(puck, CMD, CLOSE)
        for puck in FINGERS:
            h.until_still(puck)
            motor, joint = h.position(puck)
            assert 20000 < motor < h.ask(puck, CT) - 5000, motor
            assert abs(motor - 2.5 * joint) < 9500, "broken away"
            assert h.ask(puck, SG) > idle[puck] + 100
            scan = h.full_scan(puck)
            assert max(scan) > 128, scan  # 0.5 N/cm2
            # the same, in the other format: the ten greatest, in whole N/cm2
            h.tell(puck, TACT, 1)
            top = top_ten(h.expect(GROUP | puck << 5 | TOP_TEN))
            least = min(scan[c] for c in top)
            assert all(value <= least for c, value in enumerate(scan) if c not in top), (scan, top)
            assert all(abs(value - min(15, scan[c] / 256)) <= 1 for c, value in top.items()), (scan, top)
        # told again by a question, in the format that was set
        h.send(F1, [TACT])
        h.expect(GROUP | F1 << 5 | TOP_TEN)
        # a tare and "off" are not answered
        h.tell(F1, TACT, 3)
        h.nothing_more()
        h.tell(F1, TACT, 0)
        h.nothing_more()
        assert max(h.full_scan(F1)) == 0
        assert sum(h.full_scan(SPREAD)) >= 0
        # and lets go
        h.tell(F1, CMD, OPEN)
        h.until_still(F1)
        assert abs(h.position(F1)[0]) <= 5
        assert rules(h.emulator.end()) == []


def whole_hand_at_once(hand):
    """A question to a group: each member answers for itself, in any order."""
    with hand() as h:
        h.wake()

        def answers(to, what, group):
            h.send(to, [what])
            frames = [h.next() for _ in PUCKS]
            assert all(frames), f"{sum(map(bool, frames))} answers"
            found = {f.arbitration_id >> 5 & 31: f for f in frames}
            assert sorted(found) == list(PUCKS)
            assert all(f.arbitration_id == GROUP | puck << 5 | group for puck, f in found.items())
            return found

        for to in (GROUP | ALL, GROUP | HAND):
            assert all(bytes(f.data) == bytes([0x80 | STAT, 0, 2, 0]) for f in answers(to, STAT, VALUES).values())
        for puck, frame in answers(GROUP | HAND, P, POSITIONS).items():
            assert frame.dlc == (3 if puck == SPREAD else 6) and packed(frame.data)[0] == 0
        h.send(F1, [JP])
        assert h.expect(GROUP | F1 << 5 | JOINTS).dlc == 3
        # nobody is in the groups that answers go to, nor at other numbers
        for nobody in (GROUP | VALUES, GROUP | 1, 1, 10, 15):
            h.send(nobody, [STAT])
            h.nothing_more()
        # all four pads at once: five frames each, those of one puck in order
        h.tell(GROUP | HAND, TACT, 2, 4)
        seen = {puck: [] for puck in PUCKS}
        for _ in range(20):
            frame = h.next()
            assert frame and frame.arbitration_id & 0x41F == GROUP | 9, frame
            seen[frame.arbitration_id >> 5 & 31].append(frame.data[0] >> 4)
        assert all(numbers == [0, 1, 2, 3, 4] for numbers in seen.values()), seen
        assert rules(h.emulator.end()) == []


def old_membership(hand):
    """Hands of 2010 are not in group 5 until they are told to be, one by one."""
    with hand("--group", "8") as h:
        h.wake()
        h.send(GROUP | HAND, [STAT])
        h.nothing_more()
        h.set(F2, GRPC, HAND)
        h.send(GROUP | HAND, [STAT])
        h.expect(GROUP | F2 << 5 | VALUES)
        h.nothing_more()
        h.send(GROUP | 8, [STAT])
        assert {h.next().arbitration_id >> 5 & 31 for _ in range(3)} == {F1, F3, SPREAD}
        assert rules(h.emulator.end()) == []


def widths(hand):
    """Values in 2 or 4 bytes, whatever the property has; answers always in the property's own width."""
    with hand() as h:
        h.wake()
        h.set(F1, MT, 1500)
        h.set(F1, MT, 1600, 4)
        h.set(F1, MV, -7, 4)
        h.set(F1, MV, -8, 2)
        h.set(F1, E, 81487)
        h.set(F1, E, -81487)
        h.set(F1, E, -300, 2)
        h.set(F1, E, 32767, 2)
        # a question may be padded
        h.send(F1, [MT, 0])
        assert bytes(h.expect(GROUP | F1 << 5 | VALUES).data) == bytes([0x80 | MT, 0, 0x40, 0x06])
        # all in one with six bytes
        for what, value in ((TSTOP, 100), (HOLD, 1), (MT, 900), (DP, 12345)):
            h.tell(GROUP | HAND, what, value, 4)
            for puck in PUCKS:
                assert h.ask(puck, what) == value
        assert rules(h.emulator.end()) == []


def another_host(hand):
    """A node other than 0 is answered alone, positions as an ordinary property."""
    with hand() as h:
        h.wake()
        for host in (6, 9):
            for puck in PUCKS:
                h.send(host << 5 | puck, [STAT])
                assert bytes(h.expect(puck << 5 | host).data) == bytes([0x80 | STAT, 0, 2, 0])
                h.send(host << 5 | puck, [P])
                frame = h.expect(puck << 5 | host)
                assert bytes(frame.data) == bytes([0x80 | P, 0, 0, 0, 0, 0])
        assert rules(h.emulator.end()) == []


def what_no_puck_knows(hand):
    """A question about it is not answered, a setting changes nothing, and both are told at the end."""
    with hand() as h:
        h.wake()
        h.send(F1, [120])
        h.nothing_more()
        h.tell(F1, 123, 7, 4)
        h.nothing_more()
        h.send(F1, [CMD])  # a command cannot be read
        h.nothing_more()
        h.tell(F1, TEMP, 1)  # what is measured cannot be set
        assert h.ask(F1, TEMP) > 1
        h.send(F1, [])
        h.nothing_more()
        report = h.emulator.end(1)
        assert sorted(rules(report)) == ["not-readable", "not-writable", "unknown-property"], report


def reset(hand):
    """A puck that is told to reset has lost its zero, sleeps, and tells so; the others go on."""
    with hand() as h:
        h.wake()
        h.initialise()
        h.move(F1, 30000)
        h.tell(F1, CMD, 2)
        assert h.ask(F1, STAT) == 0 and h.ask(F2, STAT) == 2
        h.tell(F1, STAT, 2)
        assert h.ask(F2, MODE) == IDLE
        h.emulator.wait_for("F1 is awake", 2)
        assert h.position(F1) == (0, 0), "its zero is where it stands"
        assert rules(h.emulator.end()) == []


TESTS = (wakes, monitor_knows_little, initialises_and_moves, moves_together, holds_something, whole_hand_at_once,
         old_membership, widths, another_host, what_no_puck_knows, reset)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("--bus", default="socketcand")
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_intermixed_args()
    failed = 0
    for test in TESTS:
        if options.names and test.__name__ not in options.names:
            continue
        began = time.monotonic()
        try:
            test(lambda *more: Client(options.colift, options.bus, *more))
            print(f"ok      {test.__name__} ({time.monotonic() - began:.1f} s)", flush=True)
        except Exception as e:  # the next test has its own emulator
            failed += 1
            place = traceback.extract_tb(e.__traceback__)[-1]
            print(f"FAILED  {test.__name__}: {type(e).__name__}: {e} ({place.name}, line {place.lineno})", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
