#!/usr/bin/env python3
"""docs/bring-up.md is walked: from a bare machine to a lift by its own commands, against the emulators.

    tests/docs/walk_bring_up.py PROGRAM [--check] [--out FILE.md] [--long] [--only SECTION...] [--document FILE]

Taken from the document, in its order: every command in the tables and lines of "First steps" (arm, hand, Kinect), "The first run" and "After
a stop". What each has to print, how it has to end, and what a person does meanwhile stands in bring_up_steps.py: a push, an emergency stop, a
pulled cable, weights, Enter and the space bar come from the emulators' faults and from this script. A command of the document without
an expectation fails, and an expectation whose command left the document does too. What stands in quotation marks under "expected" has to be
printed word by word. What needs hands or eyes is listed with the reason.

The rig of "The first run" is served by `colift emulate rig` for a robot file that says `emulator: never`, as for a real robot: calibration,
dry run, a lift at the speed of T1 that is stopped, and its recovery; then the whole lift of `colift run --robot emulated`. Arm and hand are walked side by side.
--long adds what takes minutes: the calibration over the wires, wrong load data, the whole lift in T1. --out writes what each command printed.

Emulators live in real time. Nothing is judged by time, every wait has an end. Where an emulator, or this script's own clock, says that the machine
stood still, that emulator and what was carried out on it is begun anew. Ends with 0 when all of it holds, 1 with what does not, 2 without the
document, 77 where all that failed did so again and again on a machine that stood still.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import shlex
import shutil
import socket
import sys
import tempfile
import time

sys.dont_write_bytecode = True  # leaves nothing in the source tree
import bring_up_page  # noqa: E402
from bring_up_programs import Failure, FarEnd, Program, Pulse, TooLate, free_port, rules_broken, worst_late_ms  # noqa: E402
from bring_up_steps import CABLING, CLEARED_FLOOR, FAR_ENDS, STEPS  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECTIONS = {"arm": ("The arm", "First steps"), "hand": ("The hand", "First steps"), "camera": ("The camera: Kinect v1", "First steps"),
            "run": ("The first run", ""), "stop": ("After a stop", "")}
GROUPS = (("arm",), ("hand",), ("camera",), ("run", "stop"), ("emulated",))  # each with its emulators and its folder
ONE_RIG = {"run", "emulated"}  # their emulators need a processor: one at a time
TRIES = 3
NO_TIME = 77
STOOD_MS, LATE_MS = 25.0, 5.0  # of this script's clock; of an emulator by its own account
CYCLE_MS = 4  # of the arm alone: four missing answers end command mode

Item = collections.namedtuple("Item", "section step text row")  # row: (text of the command's cell, text under "expected")


def like_a_command(span):
    return re.match(r"[a-z][a-z-]+ (.* )?--\w", span) is not None


def end_of(text):
    """For people; a document of JSON is one long line."""
    return "\n".join(line[:300] for line in text.splitlines()[-25:])


def lines_of(text):
    """(heading of the first level, of the second, line)"""
    first = second = ""
    for line in text.splitlines():
        if line.startswith("# "):
            first, second = line[2:], ""
        elif line.startswith("## "):
            second = line[3:]
        yield first, second, line


def items_of(text):
    """Every command that the document's walked sections show, in order; rows without one are an item too."""
    items, block, shown, counts = [], 0, False, collections.Counter()

    def add(section, step, found, row=("", "")):
        counts[section, found] += 1
        number = counts[section, found]
        items.append(Item(section, step, found if number == 1 else f"{found} #{number}", row))

    for first, second, line in lines_of(text):
        section = next((s for s, (a, b) in SECTIONS.items() if first.startswith(a) and second.startswith(b)), None)
        if section is None or (not SECTIONS[section][1] and second):
            block = 0
            continue
        if line.startswith("|") and line.count("|") == 4:  # three cells
            step, command, expected = [cell.strip() for cell in line.split("|")[1:-1]]
            if command in ("command", "---"):
                continue
            spans = re.findall(r"`([^`]+)`", command) + [s for s in re.findall(r"`([^`]+)`", expected) if like_a_command(s)]
            for span in spans or [command]:
                add(section, step, span, (command, expected))
        elif line.startswith("    ") and line.strip().startswith("colift"):
            block += not shown
            add("emulated" if section == "run" and block > 1 else section, "", re.sub(r"\s+# .*", "", line.strip()))
        else:
            for span in re.findall(r"`(colift [^`]+)`", line):
                add(section, "", span)
        shown = line.startswith("    ")
    return items


def cabling_of(text):
    """What the sections about cabling show for a shell with rights."""
    for _, second, line in lines_of(text):
        if second.startswith("Cabling"):
            for code in [line.strip()] if line.startswith("     ") else re.findall(r"`([^`]+)`", line):
                yield from (part.strip() for part in code.split(";") if part.strip().startswith("sudo "))


def coverage(text, items):
    """What of the document has no expectation, and the other way round."""
    wrong = [f'{i.section}: "{i.text}" of the document has no expectation in bring_up_steps.py' for i in items if i.text not in STEPS[i.section]]
    shown = {(i.section, i.text) for i in items}
    wrong += [f'{section}: "{step}" of bring_up_steps.py is not in the document' for section, steps in STEPS.items()
              for step in steps if (section, step) not in shown]
    cabling = list(cabling_of(text))
    wrong += [f'cabling: "{line}" is not listed with a reason' for line in cabling if not any(re.match(p, line) for p in CABLING)]
    return wrong + [f"cabling: {p} is not in the document" for p in CABLING if not any(re.match(p, line) for line in cabling)]


def can_fail(text, items):
    """Each change of the document alone is seen; else this script says nothing."""
    lines = [line for line in text.splitlines() if line.startswith("| ") and "`colift" in line and any(line.split("|")[2].strip() == i.row[0] for i in items)]
    changes = [text.replace(line, "") for line in lines] + [text.replace("position --for 5", "position --for 6"),
               text.replace("    colift recover --robot rig.yaml", "    colift recover --robot rig.yaml\n    colift run --robot rig.yaml"),
               text.replace("sudo modprobe vcan", "sudo modprobe can")]
    return [f"change {n} of the document alone is not seen" for n, change in enumerate(changes) if change == text or not coverage(change, items_of(change))]


class Stood(Failure):
    """On a machine that stood still each time."""


class Walk:
    """One group of sections in a folder of its own."""

    def __init__(self, colift, items, group, folder, long, pulse):
        self.colift, self.items, self.group, self.folder, self.long, self.pulse = colift, items, group, folder, long, pulse
        self.far, self.ports, self.extra, self.records, self.late_ms = {}, {}, {}, [], {}
        self.done, self.tries, self.began = collections.defaultdict(list), collections.Counter(), {}  # by emulator
        self.ends, self.first = FAR_ENDS[group[0]], next(iter(FAR_ENDS[group[0]]))
        (folder / "cleared.yaml").write_text(CLEARED_FLOOR)

    # --- the emulators
    def robot_file(self):
        """rig.yaml as the document shows it, with the addresses of the emulator in use."""
        ports = self.ports
        extra = f", calibration_file: {self.extra['calibration_file']}" if self.extra.get("calibration_file") else ""
        cpu = 1 if (os.cpu_count() or 1) > 1 else 0  # driver and controller share it, as in config/emulated.yaml
        fri = f"cycle_ms: {CYCLE_MS}" if self.group[0] == "arm" else f"cycle_ms: 2, cpu: {cpu}"
        lines = ["arm: fri", f"fri: {{address: 127.0.0.1, port: {ports['arm']}, krc: 127.0.0.1, {fri}, script: colift}}", "hand: barrett",
                 f"barrett: {{can: \"socketcand:127.0.0.1:{ports['hand']}/can0\"{extra}}}", "camera: kinect",
                 f"kinect: {{source: \"emulated:{ports['camera']}\", motor: true, latency_ms: 10}}", "emulator: never"]
        if self.extra.get("calibration"):
            lines.append(f"calibration: {self.extra['calibration']}")
        (self.folder / "rig.yaml").write_text("\n".join(lines) + "\n")
        emulated = (ROOT / "config/emulated.yaml").read_text().replace("krc: 127.0.0.1", f"krc: 127.0.0.1, port: {ports['arm']}")
        emulated = emulated.replace("29536", str(ports["hand"])).replace("@colift-kinect", ports["camera"])
        (self.folder / "emulated.yaml").write_text(re.sub(r"cpu: \d+", f"cpu: {cpu}", emulated))

    def new_ports(self, name):
        self.ports = {"arm": free_port(socket.SOCK_DGRAM), "hand": free_port(socket.SOCK_STREAM),
                      "camera": f"@colift-walk-{os.getpid()}-{self.group[0]}-{name.replace(' ', '-')}-{self.tries[name]}"}

    def use(self, name):
        """The emulator of that name, started at its first use; rig.yaml is its own then."""
        if name == "none":
            if not self.ports:
                self.new_ports(name)
            self.robot_file()
            return None
        if name not in self.far:
            self.new_ports(name)
            self.robot_file()
            words, prepared = self.ends[name][0].split(), self.ends[name][1]
            where = {"krc": ["--to", f"127.0.0.1:{self.ports['arm']}", "--cycle-ms", str(CYCLE_MS)], "camera": ["--address", self.ports["camera"]],
                     "hand": ["--bus", f"socketcand:127.0.0.1:{self.ports['hand']}/can0"]}.get(words[0], [])
            self.began[name] = time.monotonic()
            self.far[name] = (FarEnd(self.colift, words + where, self.folder), self.ports)
            for command in prepared:
                self.carry_out(command, self.far[name][0], (0,))
        far, self.ports = self.far[name]
        self.robot_file()
        return far

    def end(self, name):
        """Ends one emulator; whether the program broke its rules is told by Failure."""
        far, _ = self.far.pop(name)
        try:
            self.late_ms[name] = 0.0
            report = far.report()
            self.late_ms[name] = worst_late_ms(report)
        finally:
            far.kill()
        if rules_broken(report):
            raise Failure(f'emulator "{name}": the program broke its rules: {"; ".join(rules_broken(report))}')

    def excuse(self, name, why, since):
        """After a failure: ends the emulator. Raises it anew where the machine is no excuse, or was too often."""
        try:
            if name in self.far:
                self.end(name)
        except Failure:
            pass
        late_ms, pulse_ms = self.late_ms.get(name, 0.0), self.pulse.worst_ms(since)
        stood = late_ms > LATE_MS or pulse_ms > STOOD_MS
        held_up = isinstance(why, TooLate) or "this program did not run for" in str(why)  # by its own account: no excuse in the end
        if name == "none" or not (stood or held_up):
            raise why
        self.tries[name] += 1
        still = f"the machine stood still for {max(late_ms, pulse_ms):.0f} ms"
        if self.tries[name] >= TRIES:
            raise Stood(f"{TRIES} times, {still}: {why}") if stood else why
        print(f'again   {"+".join(self.group)}: emulator "{name}": {still}; {str(why).splitlines()[0].removesuffix("; it printed:")}', flush=True)

    def repeat(self, name):
        """What was carried out on an emulator, on a new one."""
        now = self.extra
        try:
            self.use(name)
            for item, run, extra in self.done[name]:
                self.extra = extra
                self.run(item, run)
        finally:
            self.extra = now

    def surely(self, name, attempt, since):
        """What attempt() gives; on a new emulator where the machine had no time."""
        again = False
        while True:
            try:
                if again:
                    self.repeat(name)
                return attempt()
            except Failure as e:
                self.excuse(name, e, since)
            again, since = True, time.monotonic()

    def end_all(self):
        for name in list(self.far):
            self.surely(name, lambda name=name: self.end(name), self.began[name])

    # --- one command
    def carry_out(self, command, far, codes, person=(), terminal=False):
        words = shlex.split(command)
        if "--robot" not in words and words[1] == "hal" and words[3] != "replay":
            words += ["--robot", "rig.yaml"]
        program = Program([self.colift, *words[1:]], self.folder, terminal)
        try:
            for what, text in person:
                if what == "reads":
                    program.wait_for(text)
                elif what == "sees":
                    far.wait_for(text)
                elif what == "not yet" and far.seen(text):
                    raise TooLate(f"the emulator was ahead with {text!r}")
                elif what == "types":
                    program.type(text)
                elif what == "interrupts":
                    program.interrupt()
                elif what == "holds space":
                    program.hold_space()
            code = program.end()
            if code not in codes:
                raise Failure(f"ended with {code}, expected {' or '.join(map(str, codes))}")
        except Failure as e:
            raise type(e)(f"{command}: {e}; it printed:\n{end_of(program.text())}") from None
        finally:
            program.kill()
        return " ".join(["colift", *words[1:]]), program.text(), code

    def run(self, item, run):
        far = self.use(run.at or self.first)
        if run.starts:
            text = self.ends[run.at or self.first][0]
            if not set(item.text.split()[2:]) <= set(text.split()):
                raise Failure(f"{item.text}: was started as {text}")
            return f"colift emulate {text}", far.ready, 0
        if run.after:
            far.wait_for(run.after)
        for name in {name.split("/")[0] for name in run.files}:  # of an earlier command
            if (self.folder / name).is_dir():
                shutil.rmtree(self.folder / name)
            else:
                (self.folder / name).unlink(missing_ok=True)
        before = len(far.lines) if far else 0
        shown, text, code = self.carry_out(run.command or item.text, far, run.code, run.person, run.terminal)
        missing = [p for p in run.says if not re.search(p, text, re.M)]
        missing += [f"a file {name}" for name in run.files if not (self.folder / name).is_file() or not (self.folder / name).stat().st_size]
        if missing:
            raise Failure(f"{shown}: without {'; '.join(missing)}:\n{end_of(text)}")
        for pattern in run.sees:
            far.wait_for(pattern, before)
        return shown, text, code

    def all(self):
        printed = collections.defaultdict(str)
        try:
            for item in (i for i in self.items if i.section in self.group):
                runs = STEPS[item.section][item.text]
                if isinstance(runs, str):
                    self.records.append(bring_up_page.Record(item, "", runs, "", 0, (), "", ""))
                    continue
                for run in runs:
                    if run.only and (run.only == "long") != self.long:
                        continue
                    name = run.at or self.first
                    if name not in ("none", *self.far) and self.group[0] in ONE_RIG:
                        self.end_all()
                    self.extra.update(run.robot)
                    shown, text, code = self.surely(name, lambda item=item, run=run: self.run(item, run), time.monotonic())
                    self.done[name].append((item, run, dict(self.extra)))
                    printed[item.row] += text + "\n"
                    self.records.append(bring_up_page.Record(item, shown, run.here, text, code, run.says, f"{self.group[0]} {name}",
                                                             self.ends.get(name, ("",))[0]))
            for row, text in printed.items():
                for phrase in re.findall(r'"([^"]+)"', row[1]):
                    if not re.search(re.escape(phrase).replace(r"\.\.\.", ".*"), text):
                        raise Failure(f'{row[0]}: expected is "{phrase}", which was not printed')
            self.end_all()
        finally:
            for far, _ in self.far.values():
                far.kill()


def walk(colift, items, group, folder, long, pulse, kept):
    """(the walk of a group of sections, what is wrong, whether the machine had no time for it)"""
    own = folder / group[0]
    own.mkdir()
    for name in kept:
        (shutil.copytree if name.is_dir() else shutil.copy)(name, own / name.name)
    began, this = time.monotonic(), Walk(colift, items, group, own, long, pulse)
    try:
        this.all()
    except Failure as e:
        return this, [f"{'+'.join(group)}: {e}"], isinstance(e, Stood)
    print(f"ok      {'+'.join(group)} ({time.monotonic() - began:.0f} s)", flush=True)
    return this, [], False


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("--out", type=pathlib.Path, help="writes the page")
    parser.add_argument("--check", action="store_true", help="holds the document against the expectations; carries out nothing")
    parser.add_argument("--long", action="store_true", help="with what takes minutes")
    parser.add_argument("--only", nargs="+", choices=[g[0] for g in GROUPS], default=[g[0] for g in GROUPS])
    parser.add_argument("--document", type=pathlib.Path, default=ROOT / "docs/bring-up.md")
    args = parser.parse_args()
    if not args.document.is_file():
        print(f"{args.document}: there is no such document")
        return 2
    text = args.document.read_text(encoding="utf-8")
    try:
        os.nice(-10)  # of two programs that want this machine the one that lives in real time goes first, where that may be
    except OSError:
        pass
    items, program, began = items_of(text), str(args.program.resolve()), time.monotonic()
    wrong, walks, pulse = coverage(text, items) or can_fail(text, items), {}, Pulse()
    no_time = True  # was the reason of all that failed
    with tempfile.TemporaryDirectory(prefix="colift-walk-") as name:
        folder = pathlib.Path(name)

        def go(group):
            kept = [p for p in (walks["camera"].folder / n for n in ("camera.yaml", "samples")) if p.exists()] if group[0] == "run" else []
            return walk(program, items, group, folder, args.long, pulse, kept)

        only = {*args.only, *(["camera"] if "run" in args.only else [])}  # whose calibration the first run needs
        groups = [] if wrong or args.check else [g for g in GROUPS if g[0] in only]
        side_by_side = [g for g in groups if g[0] in ("arm", "hand")]
        with concurrent.futures.ThreadPoolExecutor(max(1, len(side_by_side))) as pool:
            done = list(zip(side_by_side, pool.map(go, side_by_side)))
        for group in groups:
            if group in side_by_side:
                this, bad, stood = dict(done)[group]
            elif group[0] == "run" and "camera.yaml" not in [p.name for p in walks["camera"].folder.iterdir()]:
                continue  # without a calibration there is none
            else:
                this, bad, stood = go(group)
            walks[group[0]] = this
            wrong, no_time = wrong + bad, no_time and (stood or not bad)
        pulse.stop()
        if args.out and not wrong:
            records, names = [r for w in walks.values() for r in w.records], {str(folder): "~", str(pathlib.Path(program).parent): "BIN"}
            args.out.write_text(bring_up_page.page_of(records, CABLING, names), encoding="utf-8")
    walked = sum(bool(r.shown) for w in walks.values() for r in w.records)
    print("\n".join([*wrong, f"{len(items)} places in the document, {walked} commands carried out in {time.monotonic() - began:.0f} s, {len(wrong)} wrong"]))
    return 0 if not wrong else NO_TIME if walks and no_time else 1


if __name__ == "__main__":
    sys.exit(main())
