#!/usr/bin/env python3
"""Drives `colift hal hand` as a hand would: what a program says and sends is judged at the far end of the wire, first with
pucks that behave, then with those that do not. A test in which this hand itself was held up is begun anew.

Standard library only, and nothing of CoLift's own code. Usage: hand_server_test.py COLIFT [NAME...]
"""

import itertools
import random
import re
import signal
import sys
import time

sys.dont_write_bytecode = True  # leaves nothing in the source tree
from hand_server import Hand, Program, run
from pucks import (ASLEEP, E, F1, F2, F3, FINGERS, GROUP, GRPC, IDLE, MODE, MT, NAMES, P, POSITIONS, PUCKS, READY,
                   SPREAD, STAT, TEMP, THERM, TRAPEZOID, VALUES)
from wire_tests import main

TOUCH = 60_000  # counts, where something is held
initialised = None  # what the program itself left in a hand by `init`


def ready(colift):
    """A hand whose zero is known, as `init` left one, with something to hold."""
    global initialised
    if not initialised:
        with Hand() as first:
            run(colift, first, 0, "init")
            initialised = first.state()
    hand = Hand()
    hand.set_state(initialised)
    holding(hand, TOUCH)
    return hand


def holding(hand, at):
    with hand.lock:
        for f in hand.fingers():
            f.meets = at


def named(done, *words):
    for word in words:
        assert word in done.said, f"no \"{word}\" in {done.said}"


def closing(hand):
    """The moment when F2 is under way, further from the object than it comes within the 0.1 s of most detections."""
    return lambda: hand[F2].v[MODE] == TRAPEZOID and hand[F2].counts() > 10_000


def pressing(hand):
    """The moment when all fingers press since longer than a move's end takes: the grip is held."""
    return lambda: all(f.v[MODE] == TRAPEZOID and f.load() > 300 and f.still_ms > 250 for f in hand.fingers())


def answers(puck, what, value=None):
    """Of a frame: this puck's answer about a property (with this value)."""
    def is_one(f):
        if f.sent or f.id != GROUP | puck << 5 | (POSITIONS if what == P else VALUES):
            return False
        is_value = value is None or int.from_bytes(f.data[2:], "little", signed=True) == value
        return what == P or f.data[0] & 0x7F == what and is_value
    return is_one


def asked(f):
    """Of a frame: a question about F2's position."""
    return f.sent and f.data == bytes([P]) and f.id in (GROUP | 5, F2)


def others_press(*but):
    """What a kept grip needs: the other fingers' pressing is renewed, with what was set before."""
    return lambda to, what, value: not set(but) & set(to) and (what, value) == (MODE, TRAPEZOID)


def no_command(hand, *arguments, **options):
    found = hand.commands_after(*arguments, **options)
    assert not found, f"commanded after it knew: {[([NAMES[n] for n in to], what, value) for to, what, value in found]}"


def stays(hand, fingers=FINGERS):
    """At rest, and still closed on what they held."""
    assert all(hand[f].v[MODE] == IDLE and hand[f].load() > 300 for f in fingers), "it let go"


def spoilt(colift, when, spoil, words, told, times=1, allow=others_press(*PUCKS), forgiven=None):
    """A grip in which spoil(hand) happens once, at when(hand): it ends with exit code 3 and the words, and no command was
    sent after frames like told() had told of it."""
    with ready(colift) as hand:
        hand.forgiven = forgiven
        hand.when(when(hand), lambda: spoil(hand), "fault")
        named(run(colift, hand, 3, "grip", "--for", "4"), *words)
        no_command(hand, "fault", told, times, live=F1, allow=allow)
        if when == closing:
            assert all(f.v[MODE] == IDLE for f in hand.fingers())
        return hand


def session(colift):
    """A cold hand of 2010's groups, with pads: all verbs in the order of a day."""
    with Hand(tactile=True) as hand:
        with hand.lock:
            for puck in hand.pucks.values():
                puck.v[GRPC] = 8
        named(run(colift, hand, 0, "state"), "asleep")
        assert all(hand[n].v[STAT] == ASLEEP for n in PUCKS) and all(len(f.data) == 1 for f in hand.log if f.sent)
        named(run(colift, hand, 3, "grip"), "does not know its zero")
        run(colift, hand, 0, "init")
        assert all(hand[n].true == 0 and hand[n].v[STAT] == READY for n in PUCKS)
        d = run(colift, hand, 0, "state").document
        assert [p["zero_lost"] for p in d["pucks"]] == [False] * 4 and [p["position"] for p in d["pucks"]] == [0] * 4, d
        run(colift, hand, 0, "open")
        holding(hand, TOUCH)
        d = run(colift, hand, 0, "grip", "--for", "1.5").document
        assert d["result"]["held"] and not d["slipped"] and d["loaded"], d
        # at the fingertips: as asked for F3, half of it for the two that press against it
        torque = d["state"]["torque"]
        assert all(0.15 < torque[f] < 0.3 for f in (0, 1)) and 0.3 < torque[2] < 0.55, torque
        assert all(force > 1.0 for force in d["state"]["tip_force"]), d["state"]
        stays(hand)
        named(run(colift, hand, 2, "open"), "--yes")
        stays(hand)
        run(colift, hand, 0, "open", "--yes")
        assert all(abs(f.counts()) < 600 for f in hand.fingers())
        run(colift, hand, 0, "close")
        run(colift, hand, 0, "open", "--yes")
        holding(hand, None)
        named(run(colift, hand, 1, "close"), "closed on nothing")


def late(colift):
    """Answers 20 to 60 ms late, from the start, and from when a grip is held on: named, no fault, and the grip is kept."""
    some = random.Random(7)
    with ready(colift) as hand:
        hand.delay = lambda: some.uniform(0.02, 0.06)
        d = run(colift, hand, 0, "state").document
        assert 20 < d["bus"]["round_trip_ms"] < 120, d["bus"]
        named(run(colift, hand, 0, "grip", "--for", "1"), "slow link", '"held":true')
        run(colift, hand, 0, "open", "--yes")
    with ready(colift) as hand:
        hand.when(pressing(hand), lambda: setattr(hand, "delay", lambda: some.uniform(0.02, 0.06)), "slow")
        named(run(colift, hand, 0, "grip", "--for", "2.5"), "slow link", '"held":true')


def doubled(colift):
    """Each answer twice, and three times: at once, some milliseconds later, and at once on a slow link."""
    for copies, delay in (((0.0, 0.0), 0.0), ((0.0, 0.0, 0.003), 0.0), ((0.0, 0.0), 0.03)):
        with ready(colift) as hand:
            hand.copies, hand.delay = copies, lambda: delay
            assert run(colift, hand, 0, "grip", "--for", "1").document["result"]["held"]
            run(colift, hand, 0, "open", "--yes")
            assert all(abs(f.counts()) < 600 for f in hand.fingers())


def doubled_late(colift):
    """Before each answer about MODE the one before it once more, if that is not older than 30 ms: no motion ends by it."""
    with ready(colift) as hand:
        told = {}
        def emit(identifier, data, first=hand.emit):
            if data[0] & 0x7F == MODE and len(data) == 4:
                at, old = told.get(identifier, (0.0, data))
                told[identifier] = time.monotonic(), data
                if time.monotonic() - at < 0.03:
                    first(identifier, old)
            first(identifier, data)
        hand.emit = emit
        for _ in range(4):
            run(colift, hand, 0, "grip", "--for", "0.2")
            run(colift, hand, 0, "open", "--yes")
            assert all(abs(f.counts()) < 600 for f in hand.fingers())


def reset(colift):
    """A puck that resets, twice told: what was under way to it then may still come."""
    spoil, told, but = lambda hand: hand[F2].reset(), answers(F2, STAT, ASLEEP), "of the sleeping F2"
    words = "F2 was reset and has lost its zero", "while the hand is loaded"
    hand = spoilt(colift, closing, spoil, words[:1], told, 2, forgiven=but)
    assert all(f.true < TOUCH for f in hand.fingers()), "they went on closing"
    stays(spoilt(colift, pressing, spoil, words, told, 2, others_press(F2), but))


def jump(colift):
    """An encoder that counts from somewhere else at once."""
    def spoil(hand):
        hand[F2].offset -= 30_000 if hand[F2].load() == 0 else -30_000

    told, words = answers(F2, P), ("the encoder of F2 jumped by ", "without a reset", "while the hand is loaded")
    hand = spoilt(colift, closing, spoil, words[:2], told, 2)
    assert all(f.true < TOUCH for f in hand.fingers()), "they went on closing"
    with ready(colift) as later:  # no later program may believe this zero
        later.set_state(hand.state())
        named(run(colift, later, 3, "grip"), "does not know its zero")
    stays(spoilt(colift, pressing, spoil, words, told, 2, others_press(F2)))


def far_jump_while_holding(colift):
    """Beyond the end of the finger's pressing: told as a jump, not as a lost grip, and the motor, which now runs towards that
    end from behind, is stopped within the 0.1 s in which a jump is found."""
    def spoil(hand):
        hand[F2].offset -= 300_000

    words = "the encoder of F2 jumped by ", "while the hand is loaded"
    hand = spoilt(colift, pressing, spoil, words, answers(F2, P), 2, others_press(F2))
    stays(hand, (F1, F3))
    # 200 counts in each ms
    assert hand[F2].true > TOUCH - 20_000, f"F2 opened from {TOUCH} to {hand[F2].true:.0f} counts"


def saved_zero(colift):
    """A mark that somebody saved: the joint's encoder contradicts it, or the puck's clock does. Nothing is commanded."""
    joint = lambda puck: puck.__dict__.update(true=50_000.0, joint_offset=-6000.0)
    clock = lambda puck: puck.__dict__.update(power_on=puck.power_on - 5000)
    told = (joint, "motor and joint encoder of F2 contradict each other"), (clock, "F2 is of an earlier life")
    for (spoil, words), verb in itertools.product(told, ("grip", "open")):
        with ready(colift) as hand:
            spoil(hand[F2])
            hand.when(lambda: True, lambda: None, "begin")
            named(run(colift, hand, 3, verb), words, "init")
            no_command(hand, "begin")


def hot(colift, sensor=TEMP, groups=(FINGERS, (F3,))):
    """57 C and derated, as the page has it, all fingers or one: no grip is reported, and the heat is the reason."""
    for who, as_text in itertools.product(groups, (False, True)):
        with ready(colift) as hand:
            for f in who:
                hand[f].v[sensor], hand[f].derate_by = 57, sensor
            d = run(colift, hand, 1, "grip", "--for", "1", as_text=as_text)
            assert "it holds something" not in d.said, d.said
            assert as_text or not d.document["result"]["held"], d.document["result"]
            assert all(f.v[MODE] == IDLE for f in hand.fingers())
            reason = d.said[d.said.index("colift hal hand grip: "):]  # what a person reads
            assert "57 C" in reason, reason


def hot_motor(colift):
    """The same by the motor's sensor, and not its puck's."""
    hot(colift, THERM, (FINGERS,))


def foreign_settings(colift):
    """Another node, or another program on node 0, sets something, seen on the bus."""
    for when, node, what, value, words in ((closing, 6, MT, 3000, "MT of F1 to 3000"),
                                           (pressing, 6, MT, 3000, "MT of F1 to 3000"),
                                           (pressing, 0, MODE, 0, "MODE of F1 to 0")):
        spoilt(colift, when, lambda hand: hand.foreign(node, F1, what, value),
               (f"another program (node {node}) commands the hand: it set {words}",),
               lambda f: not f.sent and f.id == node << 5 | F1)


def foreign_unseen(colift):
    """A setting that no gateway forwarded: found by reading back."""
    for what, value in ((MT, 3000), (E, 150_000)):
        spoilt(colift, pressing, lambda hand: hand[F3].v.update({what: value}),
               ("another program commands the hand", f"of F3 is {value}"), answers(F3, what, value), 2)


def foreign_questions(colift):
    """A program that only asks is named and disturbs nothing."""
    with ready(colift) as hand:
        hand.when(pressing(hand), lambda: [hand.emit(6 << 5 | F1, bytes([P])) for _ in range(200)], "asks")
        named(run(colift, hand, 0, "grip", "--for", "1"), "another program asks the pucks too")


def silent_from_the_start(colift):
    with ready(colift) as hand:
        hand[F2].dead = True
        for f in hand.fingers():
            f.true = 40_000.0
        hand.when(lambda: True, lambda: None, "begin")
        named(run(colift, hand, 3, "state"), "F2 is silent")
        named(run(colift, hand, 3, "grip"), "F2 is silent")
        no_command(hand, "begin")
        d = run(colift, hand, 3, "emergency-open", "--yes").document
        assert [f["answers"] for f in d["fingers"]] == [True, False, True], d
        assert [f.true for f in hand.fingers()] == [0, 40_000, 0]


def silent_later(colift):
    """One finger, and the whole hand."""
    def off(hand, pucks):
        [setattr(hand[n], "dead", True) for n in pucks]

    words = "F2 (node 12) is silent", "not read back, unknown: F2"
    spoilt(colift, closing, lambda hand: off(hand, (F2,)), words, asked, 3)
    spoilt(colift, pressing, lambda hand: off(hand, (F2,)), words, asked, 3, others_press(F2))
    spoilt(colift, pressing, lambda hand: off(hand, PUCKS), ("all four pucks are silent",), asked, 3, others_press())


FRAMES = ("zzz 1.0 00", "566 1.0 82", "566 now 850000 00", "563 1.0", "563 1.0 82F9", "566 1.0 8500020000000000FF",
          "566 1.0 05000000", "00000566 1.0 85000000", "566 1.0 85010000", "586 1.0 FD000000", "5E6 1.0 85000000",
          "569 1.0 F000000000000000")
GARBAGE = [f"< frame {f} >".encode() for f in FRAMES] + [b"\r\n\0\xff\xfe>>", b"<<<< ", b"< " + b"x" * 300 + b" >", b"< ok >",
                                                         b"< hi >", b"< error unknown command >", b"< frame 56"]


def garbage(colift):
    """Before each frame: what is no frame, no answer, or no puck's. None of it costs the grip."""
    with ready(colift) as hand:
        rubbish = itertools.cycle(GARBAGE)
        hand.noise = lambda: next(rubbish)
        run(colift, hand, 0, "state")
        d = run(colift, hand, 0, "grip", "--for", "1").document
        assert d["result"]["held"] and d["bus"]["rejected"] > 100, d["bus"]
        run(colift, hand, 0, "open", "--yes")


def no_gateway(colift):
    """Something else listens there, or a gateway without this bus."""
    for greeting, words in ((b"SSH-2.0-OpenSSH_9.2\r\n", "no greeting within 2 s"), (b"< error no such bus >", "no such bus"),
                            (b"< h$i >", "is not socketcand")):
        with Hand() as hand:
            hand.greeting = greeting
            named(run(colift, hand, 3, "state"), words)
            assert not hand.log


def gateway_gone(colift):
    """It closes the connection and is not back. Nobody renews: each puck ends its pressing, and its worm holds."""
    for when in (closing, pressing):
        with ready(colift) as hand:
            hand.when(when(hand), lambda: hand.hang_up(True), "gone")
            named(run(colift, hand, 3, "grip"), "the CAN interface is down or its adapter is unplugged")
            hand.until(lambda: all(f.v[MODE] == IDLE for f in hand.fingers()), "motors at rest")
            stays(hand)


def gateway_back_while_closing(colift):
    """It closes the connection and takes another: at the time when the program gives up, and before."""
    for more in ("", ", reopen_s: 0.2"):
        with ready(colift) as hand:
            hand.when(closing(hand), lambda: hand.hang_up(False), "gone")
            d = Program(colift, hand, "grip", "--for", "2", more=more).end(None)
            no_command(hand, "gone", lambda f: f.sent)
            hand.until(lambda: all(f.v[MODE] == IDLE for f in hand.fingers()), "motors at rest")
            # given up while it was away, or back in time for a grip that nobody can vouch for
            assert d.code in (1, 3) and re.search("interface is down|bus-off or down|bus was lost", d.said), (
                d.code, d.document["result"])
            loose = hand[SPREAD].v[MODE] == IDLE and any(f.load() for f in hand.fingers())
            assert not loose, "the spread was let go with the fingers on something"


def gateway_back_while_holding(colift, shall_say=""):
    """The same under a grip: it is held on to, and the pressing is renewed with what was set before."""
    with ready(colift) as hand:
        hand.when(pressing(hand), lambda: hand.hang_up(False), "gone")
        d = run(colift, hand, 0, "grip", "--for", "2", more=", reopen_s: 0.2")
        assert d.document["result"]["held"] and d.document["result"]["bad_states"] > 10, d.document["result"]
        no_command(hand, "gone", lambda f: f.sent, allow=others_press())
        stays(hand)
        assert re.search(shall_say, d.said), f"no \"{shall_say}\" in what was told"


def gateway_back_is_named(colift):
    gateway_back_while_holding(colift, "interface (is|was) down|bus-off|gateway (was|closed|is back)|connection to the bus was lost")


def killed(colift):
    """SIGKILL of a grip: the next program names the motors that still press; they end by themselves; a third opens."""
    with ready(colift) as hand:
        grip = Program(colift, hand, "grip", "--for", "30")

        def kill():
            grip.process.send_signal(signal.SIGKILL)
            hand.frozen = True  # what a puck does by itself comes later
        hand.when(pressing(hand), kill, "killed")
        grip.end(-signal.SIGKILL)
        named(run(colift, hand, 0, "state", as_text=True), *(f"{NAMES[f]} is on (MODE 5)\n" for f in FINGERS))
        d = run(colift, hand, 0, "state").document
        assert [p["mode"] for p in d["pucks"][:3]] == [TRAPEZOID] * 3 and not any(p["zero_lost"] for p in d["pucks"]), d
        hand.frozen = False
        hand.until(lambda: all(f.v[MODE] == IDLE for f in hand.fingers()), "motors at rest")
        assert "is on" not in run(colift, hand, 0, "state", as_text=True).said
        named(run(colift, hand, 2, "open"), "--yes")
        named(run(colift, hand, 2, "emergency-open"), "--yes")
        stays(hand)
        d = run(colift, hand, 0, "emergency-open", "--yes").document
        assert all(f["answers"] and f["rests"] and f["opened_deg"] > 30 for f in d["fingers"]), d
        assert all(f.true == 0 and f.v[MODE] == IDLE for f in hand.fingers())


def killed_and_opened_at_once(colift):
    """The same, opened while the motors still press."""
    with ready(colift) as hand:
        grip = Program(colift, hand, "grip", "--for", "30", more=", press_ms: 20000")
        hand.when(pressing(hand), lambda: grip.process.send_signal(signal.SIGKILL), "killed")
        grip.end(-signal.SIGKILL)
        assert all(f.v[MODE] == TRAPEZOID for f in hand.fingers())
        d = run(colift, hand, 0, "emergency-open", "--yes").document
        assert all(f["rests"] for f in d["fingers"]) and all(f.true == 0 for f in hand.fingers()), d


TESTS = (session, late, doubled, doubled_late, reset, jump, far_jump_while_holding, saved_zero, hot, hot_motor,
         foreign_settings, foreign_unseen, foreign_questions, silent_from_the_start, silent_later, garbage, no_gateway,
         gateway_gone, gateway_back_while_closing, gateway_back_while_holding, gateway_back_is_named, killed,
         killed_and_opened_at_once)


if __name__ == "__main__":
    sys.exit(main(TESTS, Hand, attempts=6, at_once=3))
