#!/usr/bin/env python3
"""Records the sessions of tests/data/hand_sessions anew: `colift hal hand VERB --bus-log` at the hand that Python plays, which
shares no code with the emulated one, and some at `colift emulate hand`. A session in which this machine held the hand up is
begun anew; one that replay finds different from itself is not kept.

Usage: record_hand_sessions.py COLIFT [NAME...]
"""

import functools
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leaves nothing in the source tree
from hand_server import Hand, run
from hand_server_test import closing, holding, named, pressing, ready
from pucks import F1, F2, FINGERS, GRPC, MT, ROLE, SPREAD, TEMP
from wire_tests import main

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "data" / "hand_sessions"
MOST_BYTES = 150 * 1024


class Emulated:
    """`colift emulate hand` behind a gateway, initialised, with a ball of 0.10 m, as long as the block lasts."""

    def __init__(self, colift, *faults):
        options = [o for fault in faults for o in ("--fault", fault)]
        self.process = subprocess.Popen([colift, "emulate", "hand", "--bus", "socketcand:127.0.0.1:0/can0", "--plant", "light",
                                         "--width", "0.10", "--json", *options],
                                        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.port = int(self.wait_for(r"ready: hand on .*port (\d+)")[1])
        self.began = time.monotonic()
        run(colift, self, 0, "init", "--yes")

    def wait_for(self, pattern):
        for line in self.process.stderr:
            if found := re.search(pattern, line):
                return found
        raise AssertionError(f"the emulated hand never said {pattern}")

    def until(self, at_s):
        """Of its own time, which begins when it is ready."""
        left = self.began + at_s - time.monotonic()
        assert left > 0, "this machine held the emulated hand up"
        time.sleep(left)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.communicate()


def cold():
    """As after switching on, with pads on its fingers and with the third group of 2010's hands."""
    hand = Hand(tactile=True)
    with hand.lock:
        hand[SPREAD].role &= ~0x1000
        hand[SPREAD].v[ROLE] = hand[SPREAD].role
        for puck in hand.pucks.values():
            puck.v[GRPC] = 8
    return hand


def state_of_a_cold_hand(colift, log):
    with cold() as hand:
        named(run(colift, hand, 0, "state", *log), "asleep")


def init_of_a_cold_hand(colift, log):
    with cold() as hand:
        run(colift, hand, 0, "init", *log)


def grip_refused_without_zero(colift, log):
    with cold() as hand:
        named(run(colift, hand, 3, "grip", *log), "does not know its zero")


def preshape(colift, log):
    with ready(colift) as hand:
        run(colift, hand, 0, "preshape", "40", *log)


def grip_held(colift, log):
    with ready(colift) as hand:
        named(run(colift, hand, 0, "grip", "--for", "0.8", *log), '"held":true')


def release_of_a_held_object(colift, log):
    with ready(colift) as hand:
        run(colift, hand, 0, "grip", "--for", "0.3")
        run(colift, hand, 0, "open", "--yes", *log)


def grip_on_nothing(colift, log):
    with ready(colift) as hand:
        holding(hand, None)
        named(run(colift, hand, 1, "close", *log), "closed on nothing")


def grip_slips(colift, log):
    with ready(colift) as hand:
        hand.when(pressing(hand), lambda: holding(hand, 90_000), "slips")
        named(run(colift, hand, 1, "grip", "--for", "2", *log), "slipped")


def grip_too_weak_with_heat(colift, log):
    with ready(colift) as hand:
        for f in FINGERS:
            hand[f].v[TEMP], hand[f].derate_by = 57, TEMP
        named(run(colift, hand, 1, "grip", "--for", "0.5", *log), "57 C")


def grip_over_a_slow_link(colift, log):
    some = random.Random(7)
    with ready(colift) as hand:
        hand.delay = lambda: some.uniform(0.02, 0.06)
        named(run(colift, hand, 0, "grip", "--for", "0.8", *log), "slow link", '"held":true')


def spread_turned_under_load(colift, log):
    with ready(colift) as hand:
        spread = hand[SPREAD]

        def turn(own=spread.step):
            def step(ms, now):
                own(ms, now)
                spread.true = min(spread.true + 20 * ms, 4000)  # 100 degrees/s, to 20 degrees
            spread.step = step

        hand.when(pressing(hand), turn, "turns")
        named(run(colift, hand, 1, "grip", "--for", "2", *log), "the spread turned by")


def second_master_while_closing(colift, log):
    with ready(colift) as hand:
        hand.when(closing(hand), lambda: hand.foreign(6, F1, MT, 3000), "sets")
        named(run(colift, hand, 3, "grip", *log), "another program (node 6) commands the hand")


def silent_puck_while_closing(colift, log):
    with ready(colift) as hand:
        hand.when(closing(hand), lambda: setattr(hand[F2], "dead", True), "silent")
        named(run(colift, hand, 3, "grip", *log), "F2 (node 12) is silent")


def reset_puck_while_holding(colift, log):
    with ready(colift) as hand:
        hand.forgiven = "of the sleeping F2"
        hand.when(pressing(hand), hand[F2].reset, "reset")
        named(run(colift, hand, 3, "grip", *log), "F2 was reset and has lost its zero")


def emulated_grip_over_a_slow_link(colift, log):
    with Emulated(colift, "8:late=30:60") as hand:
        hand.wait_for("fault begins: 8:late")
        named(run(colift, hand, 0, "grip", "--for", "0.5", *log), "slow link", '"held":true')


def emulated_spread_turned_under_load(colift, log):
    with Emulated(colift, "10:turn=6000:2") as hand:
        hand.until(8.5)  # half a second of start and a second of closing before
        named(run(colift, hand, 1, "grip", "--for", "3", *log), "the spread turned by")


def emulated_grip_top_ten(colift, log):
    with Emulated(colift) as hand:
        named(run(colift, hand, 0, "grip", "--for", "0.5", *log, more=", tactile: top10"), '"held":true')


SESSIONS = (state_of_a_cold_hand, init_of_a_cold_hand, grip_refused_without_zero, preshape, grip_held, release_of_a_held_object,
            grip_on_nothing, grip_slips, grip_too_weak_with_heat, grip_over_a_slow_link, spread_turned_under_load,
            second_master_while_closing, silent_puck_while_closing, reset_puck_while_holding, emulated_grip_over_a_slow_link,
            emulated_spread_turned_under_load, emulated_grip_top_ten)


def recording(session):
    @functools.wraps(session)
    def record(colift):
        kept = FOLDER / f"{session.__name__}.log"
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / kept.name
            session(colift, ("--bus-log", str(file)))
            assert Hand.longest_pause <= Hand.MAX_PAUSE, "this machine held the hand up"
            played = subprocess.run([colift, "hal", "hand", "replay", str(file)], capture_output=True, text=True)
            listed = kept.with_suffix(".differences").exists()  # then the test judges
            assert listed or played.returncode == 0, played.stdout + played.stderr
            assert file.stat().st_size <= MOST_BYTES, f"{file.stat().st_size} bytes, kept are at most {MOST_BYTES}"
            shutil.copyfile(file, kept)
    return record


if __name__ == "__main__":
    sys.exit(main([recording(s) for s in SESSIONS], Hand, attempts=6))
