#!/usr/bin/env python3
"""Drives `colift hal hand preshape DEG --fingers DEG` as a hand would: what is sent to which puck in which order, what is
reached, what is refused, and where it ends on something in the way.

Standard library only, and nothing of CoLift's own code. Usage: hand_preshape_test.py COLIFT [NAME...]
"""

import sys

sys.dont_write_bytecode = True  # leaves nothing in the source tree
from hand_server import Hand, UNITS_PER_NM, run
from hand_server_test import holding, named, ready
from pucks import E, F1, F2, F3, FINGERS, IDLE, MODE, MT, NAMES, SPREAD, TRAPEZOID
from wire_tests import main

COUNTS_PER_TURN, WORM, SPREAD_GEAR = 4096, 125, 17.5  # as published; a worm's turn is of a finger's inner link


def settings(hand, *what):
    """(pucks, property, value) of each setting of these properties that was sent, in order."""
    with hand.lock:
        sent = [f for f in hand.log if f.sent and f.data[0] & 0x80 and f.data[0] & 0x7F in what]
        return [(tuple(p.node for p in hand.members(f.id)), f.data[0] & 0x7F, int.from_bytes(f.data[2:], "little", signed=True))
                for f in sent]


def degrees(puck):
    return puck.counts() / COUNTS_PER_TURN * 360 / (WORM if puck.finger else SPREAD_GEAR)


def partly_closed(colift):
    """The spread first, then one finger after the other to the angle, with no more than the torque of the option's default."""
    with ready(colift) as hand:
        holding(hand, None)
        d = run(colift, hand, 0, "preshape", "40", "--fingers", "30").document
        assert abs(degrees(hand[SPREAD]) - 40) < 1.5, degrees(hand[SPREAD])
        assert all(abs(degrees(f) - 30) < 0.5 and f.v[MODE] == IDLE for f in hand.fingers()), d
        assert [(f["finger"], f["rests"], f["result"]["outcome"]) for f in d["fingers"]] == [
            (NAMES[f], True, "done") for f in FINGERS], d["fingers"]
        assert all(abs(f["to_deg"] - 30) < 0.5 for f in d["fingers"]), d["fingers"]

        begun = [to for to, what, value in settings(hand, MODE) if value == TRAPEZOID]
        assert begun[-3:] == [(f,) for f in FINGERS] and (SPREAD,) in begun[:-3], begun
        modes = settings(hand, MODE)
        for one, after in ((F1, F2), (F2, F3)):  # a motor is off before the next one goes on
            on = len(modes) - 1 - modes[::-1].index(((after,), MODE, TRAPEZOID))
            assert [value for to, _, value in modes[:on] if to == (one,)][-1] == IDLE, (NAMES[one], modes)
        ends = {to: value for to, _, value in settings(hand, E)}
        wanted = round(30 / 360 * WORM * COUNTS_PER_TURN)
        assert all(abs(ends[(f,)] - wanted) <= 1 for f in FINGERS), (ends, wanted)
        torques = {to: value for to, _, value in settings(hand, MT)}
        assert all(0 < torques[(f,)] <= 0.5 * UNITS_PER_NM for f in FINGERS), torques


def open_again(colift):
    """The fingers are opened before the spread turns, and stay open at 0."""
    with ready(colift) as hand:
        holding(hand, None)
        run(colift, hand, 0, "preshape", "40", "--fingers", "30")
        run(colift, hand, 0, "preshape", "0", "--fingers", "0", "--yes")
        assert all(abs(degrees(p)) < 1.5 for p in hand.pucks.values()), [degrees(p) for p in hand.pucks.values()]


def beyond_its_range(colift):
    """Refused before anything is asked of the hand."""
    for angle in ("138", "-1", "nan", "inf"):
        with ready(colift) as hand:
            named(run(colift, hand, 2, "preshape", "40", "--fingers=" + angle), "expected 0 to 137")
            assert not hand.log


def something_in_the_way(colift):
    """A finger that meets something is the last that moves."""
    with ready(colift) as hand:
        holding(hand, None)
        hand[F2].meets = 20_000
        d = run(colift, hand, 1, "preshape", "0", "--fingers", "30").document
        assert [(f["finger"], f["rests"], f["result"]["outcome"]) for f in d["fingers"]] == [
            ("F1", True, "done"), ("F2", True, "failed")], d["fingers"]
        assert 14 < degrees(hand[F2]) < 20 and abs(degrees(hand[F3])) < 0.5, [degrees(f) for f in hand.fingers()]


TESTS = (partly_closed, open_again, beyond_its_range, something_in_the_way)


if __name__ == "__main__":
    sys.exit(main(TESTS, Hand, attempts=6))
