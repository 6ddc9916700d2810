#!/usr/bin/env python3
"""config/krl/colift.src is a program, and the one that the emulated controller plays.

    tests/docs/check_krl.py [ROOT]

Of the KRL source: every block is closed by its own word, every name that is assigned or called is declared, there is a .dat list beside it,
no PTP leads to where the arm is, and its goal is changed before. Of both: the same motions, strategies and FRI calls in the same order, the same version and the
same times; before each friStart the motion and the waits that docs/krl-hand-shakes.md says. Not checked: what only the controller's compiler knows (types, system variables).

Ends with 0 when all of it holds, 1 with a line for each exception.
"""

import pathlib
import re
import sys

OPENS = {"IF": "ENDIF", "FOR": "ENDFOR", "LOOP": "ENDLOOP", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "DEF": "END"}
CALLS = {"BAS", "FRISTOP", "FRICLOSE", "FRIOPEN", "FRISTART", "FRISETUP"}
# what the emulator's program says of the same steps
STEPS = {"ptp_here": "PTP", "set_strategy": "STRATEGY", "fri_open": "OPEN", "fri_quality": "QUALITY",
         "fri_start": "START", "fri_stop": "STOP", "fri_close": "CLOSE"}


def lines_of(text):
    """(number, words) without comments, header lines and what stands in strings."""
    for number, line in enumerate(text.splitlines(), 1):
        line = re.sub(r'"[^"]*"', '""', line).split(";")[0].strip()
        if line and not line.startswith("&"):
            yield number, line


def check_syntax(text):
    bad, stack, declared, routines = [], [], {}, set(re.findall(r"(?m)^DEF (\w+)", text))
    routine = None
    for number, line in lines_of(text):
        word = re.match(r"\W*(\w*)", line).group(1).upper()
        if word == "DEF":
            routine = re.match(r"DEF (\w+)", line).group(1)
            declared[routine] = set()
        if word in OPENS:
            stack.append((word, number))
            if word == "IF" and not line.endswith("THEN"):
                bad.append(f"{number}: IF without THEN")
        elif word in OPENS.values():
            opened = stack.pop() if stack else ("nothing", number)
            if OPENS.get(opened[0]) != word:
                bad.append(f"{number}: {word} closes {opened[0]} of line {opened[1]}")
        elif word in ("ELSE", "CASE", "DEFAULT"):
            inside = stack[-1][0] if stack else "nothing"
            if inside != ("IF" if word == "ELSE" else "SWITCH"):
                bad.append(f"{number}: {word} inside of {inside}")
        declaration = re.match(r"(?:DECL\s+)?(?:INT|REAL|BOOL|FRISTATE|E6AXIS)\s+([\w\s,]+)$", line)
        if declaration:
            declared[routine] |= {name.strip() for name in declaration.group(1).split(",")}
            continue
        if line.count("(") != line.count(")") or line.count("{") != line.count("}"):
            bad.append(f"{number}: a bracket is not closed")
        assigned = re.match(r"(?:FOR\s+)?([A-Za-z]\w*)(?:\.\w+)?\s*=[^=]", line)
        if assigned and routine and assigned.group(1) not in declared[routine]:
            bad.append(f"{number}: {assigned.group(1)} is not declared in {routine}")
        for called in re.findall(r"(?<![\w$#.])([A-Za-z]\w*)\s?\(", line):
            if called.upper() in OPENS or called.upper() in ("AND", "OR", "NOT", "WHILE", "IF"):
                continue
            if called not in routines and called.upper() not in CALLS:
                bad.append(f"{number}: {called} is called and nowhere defined")
        for name in re.findall(r"(?<![\w$#.])([a-z]\w*)(?![\w(])", line.split("DEF")[0]):
            if routine and name not in declared[routine] and name not in routines:
                bad.append(f"{number}: {name} is not declared in {routine}")
        goal = re.match(r"PTP\s+(\w+)", line)
        if goal and not re.search(r"\b%s\.\w+\s*=\s*%s\.\w+\s*[+-]" % (goal.group(1), goal.group(1)), text):
            bad.append(f"{number}: the goal of this PTP is where the arm is; such a motion may be left out")
        if re.match(r"PTP\s+\$", line):
            bad.append(f"{number}: a PTP to where the arm is may be left out, and the brakes stay closed")
    bad += [f"{number}: {word} is never closed" for word, number in stack]
    return bad


def routines_of(text):
    found, name = {}, None
    for _, line in lines_of(text):
        start = re.match(r"DEF (\w+)", line)
        if start:
            name = start.group(1)
            found[name] = []
        elif line == "END":
            name = None
        elif name:
            found[name].append(line)
    return found


def steps_of(lines, routines):
    """Motions and FRI calls in the order of the text, with the program's own routines in their places."""
    steps = []
    for line in lines:
        call = re.match(r"(\w+)\s?\(", line)
        if call and call.group(1) in routines and call.group(1) != "start_fri":
            steps += steps_of(routines[call.group(1)], routines)
        for pattern, step in ((r"^PTP\b", "PTP"), (r"STIFFNESS\.STRATEGY", "STRATEGY"), (r"\bFRIOPEN\b", "OPEN"),
                              (r"WHILE.*\$FRIQUALITY", "QUALITY"), (r"\bFRISTART\b", "START"),
                              (r"\bFRISTOP\b", "STOP"), (r"\bFRICLOSE\b", "CLOSE")):
            if re.search(pattern, line):
                steps.append(step)
    return steps


def krl_program(text):
    routines = routines_of(text)
    main = routines["colift"]
    loop, two, three, default = (next(i for i, line in enumerate(main) if re.match(p, line))
                                 for p in (r"LOOP$", r"CASE 2$", r"CASE 3$", r"DEFAULT$"))
    one = next(i for i, line in enumerate(main) if re.match(r"CASE 1$", line))
    begin = steps_of(main[:loop], routines)
    # nothing may be left of a run before; the emulated controller begins with nothing
    if begin[:2] == ["STOP", "CLOSE"]:
        begin = begin[2:]
    start = steps_of(routines["start_fri"], routines) if "start_fri" in main[one + 1] else []
    return {"begin": begin, "start": start, "stop": steps_of(main[two:three], routines),
            "close": steps_of(main[three:default], routines), "silent PC": steps_of(main[loop:one], routines)}


def played(text):
    """The same of sim_hal/emulator/krc/krl_script_colift.cpp."""
    def body(name):
        found = re.search(r"\n  void %s\(KrlHost& krc\)(?: override)? \{\n(.*?)\n  \}\n" % name, text, re.S)
        return found.group(1) if found else ""

    def steps(code):
        found = [STEPS[call] for call in re.findall(r"krc\.(\w+)\(", code) if call in STEPS]
        return [step for i, step in enumerate(found) if i == 0 or found[i - 1] != step]

    take = body("take")
    stop, close = take.find("case kStop"), take.find("case kClose")
    return {"begin": steps(body("begin")), "start": steps(body("ask_start") + body("start")),
            "stop": steps(take[stop:close]), "close": steps(take[close:]) + steps(body("poll")),
            "silent PC": steps(body("watch"))}


def krl_figures(text):
    def find(pattern, scale=1.0):
        found = re.search(pattern, text, re.S)
        return float(found.group(1)) * scale if found else None

    return {"kVersion": find(r"\$FRI_TO_INT\[1\] = (\d+)"), "kPeriod_s": find(r"ENDIF\n\s+WAIT SEC ([\d.]+)\nENDLOOP"),
            "kSettles_s": find(r"\$FRISTATE == #MON\nWAIT SEC ([\d.]+)"), "kQuality_s": find(r"\$TIMER\[2\] > (\d+)", 1e-3),
            "kCommand_s": find(r"\$TIMER\[2\] < (\d+)", 1e-3), "kHeartbeat_s": find(r"pc_silent = (\d+)", 1e-3),
            "kClosing_s": find(r"WAIT SEC ([\d.]+)\n\s+state = FRICLOSE")}


def check_waits(krl, page, round_s):
    """Before each friStart: the motion with its wait, then the strategy, then a round in which the PC sees it."""
    routines, bad = routines_of(krl), []
    said = re.search(r"PTP of A6 by 0\.05 degrees and a wait of ([\d.]+) s \(again before each start", page)
    if not said or routines["small_motion"][-2:] != ["PTP there", f"WAIT SEC {said and said.group(1)}"]:
        bad.append(f"after the motion the page waits {said and said.group(1)} s, the source does {routines['small_motion'][-1]}")
    starts = 0
    for name, lines in routines.items():
        depth, done = 0, []  # what is done in any case, in order
        for line in lines:
            word = re.match(r"\W*(\w*)", line).group(1).upper()
            depth -= word in OPENS.values()
            wait = re.match(r"WAIT SEC ([\d.]+)$", line)
            if "FRISTART" in line:
                starts += 1
                if done[-3:] != ["motion", "strategy", f"wait {round_s:g}"]:
                    bad.append(f"{name}: before friStart comes {', '.join(done) or 'nothing'}")
            elif depth == 0 and line.startswith("small_motion"):
                done.append("motion")
            elif depth == 0 and line == "$STIFFNESS.COMMIT = TRUE":
                done.append("strategy")
            elif depth == 0 and wait:
                done.append(f"wait {float(wait.group(1)):g}")
            depth += word in OPENS
    return bad if starts else bad + ["no friStart"]


def check(krl, cpp):
    bad = check_syntax(krl)
    if bad:
        return bad
    own, emulated = krl_program(krl), played(cpp)
    bad = [f"{part}: the source does {own[part]}, the emulator plays {emulated[part]}" for part in own
           if own[part] != emulated[part]]
    for name, value in krl_figures(krl).items():
        found = re.search(r"\b%s = ([\d.]+)" % name, cpp)
        if value is None or not found or abs(float(found.group(1)) - value) > 1e-9:
            bad.append(f"{name}: {value} in the source, {found.group(1) if found else None} in the emulator")
    return bad


def check_addresses(texts):
    """One PC, one KRC and one port in every text that names them: an operator copies from all of them."""
    ways = {"the PC": (r"FRIHOST=(\d[\d.]+\d)", r'FRISETUP\("([\d.]+)"', r"\baddress: (\d[\d.]+\d)", r"ip addr add ([\d.]+)/"),
            "the KRC": (r"\bkrc: (\d[\d.]+\d)",),
            "the port": (r"FRISOCK=(\d+)", r'FRISETUP\("[\d.]+", (\d+)', r"\bport: (\d+)")}
    bad = []
    for what, patterns in ways.items():
        found = {(value, name) for name, text in texts.items() for p in patterns for value in re.findall(p, text) if value != "127.0.0.1"}
        if len({value for value, _ in found}) != 1:
            bad.append(f"{what} is {', '.join(f'{value} in {name}' for value, name in sorted(found)) or 'named nowhere'}")
    return bad


def can_fail(krl, cpp, page, round_s):
    """Each change of one side alone is seen; else this test says nothing."""
    waits = (krl.replace("PTP there\nWAIT SEC 0.1", "PTP there\nWAIT SEC 0.01"), krl.replace("PTP there\nWAIT SEC 0.1", "PTP there"),
             krl.replace("WAIT SEC 0.02\n\n$TIMER[2] = 0", "$TIMER[2] = 0"), krl.replace("$FRI_TO_INT[2] = 2\nsmall_motion( )", "$FRI_TO_INT[2] = 2"))
    changes = ((krl.replace("there.A6 = there.A6 - 0.05", "THERE.A6 = there.A6 - 0.05"), cpp),
               (krl.replace("  PTP", "").replace("PTP there\n", ""), cpp), (krl.replace("PTP there", "PTP $AXIS_ACT"), cpp),
               (re.sub(r"there\.A6 = there\.A6 [+-] 0\.05", "there.A6 = there.A6", krl), cpp),
               (krl.replace("ENDSWITCH\n", "", 1), cpp), (krl.replace("DECL E6AXIS there\n", ""), cpp),
               (krl.replace("pc_silent = 1000", "pc_silent = 2000"), cpp),
               (krl.replace("$FRI_TO_INT[2] = 2\nsmall_motion( )", "$FRI_TO_INT[2] = 2"), cpp),
               (krl, cpp.replace("      krc.ptp_here();\n", "")), (krl, cpp.replace("kQuality_s = 5.0", "kQuality_s = 4.0")),
               (krl, cpp.replace('krc.fri_close("the client asked for the end");', "")))
    return [f"change {i} of one side alone is not seen" for i, change in enumerate(changes)
            if change == (krl, cpp) or not check(*change)] + [
                f"change {i} of the waits is not seen" for i, change in enumerate(waits)
                if change == krl or not check_waits(change, page, round_s)] + (
                    [] if check_waits(krl, page.replace("wait of 0.1 s", "wait of 0.2 s"), round_s) else ["another wait on the page is not seen"])


def main():
    root = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parents[2])
    krl = (root / "config/krl/colift.src").read_text()
    cpp = (root / "sim_hal/emulator/krc/krl_script_colift.cpp").read_text()
    page = (root / "docs/krl-hand-shakes.md").read_text()
    round_s = float(re.search(r"\bkPeriod_s = ([\d.]+)", cpp).group(1))
    bad = check(krl, cpp) + check_waits(krl, page, round_s) or can_fail(krl, cpp, page, round_s)
    texts = {name: (root / name).read_text()
             for name in ("docs/bring-up.md", "config/real.yaml", "config/krl/README.md", "config/krl/colift.src")}
    bad += check_addresses(texts)
    for old, new in (("192.168.0.1", "192.168.0.2"), ("krc: 192.168.0.20", "krc: 192.168.0.21"), ("49938", "49939")):
        for name in texts:
            if old in texts[name] and name != "config/krl/README.md" and not check_addresses({**texts, name: texts[name].replace(old, new)}):
                bad.append(f"another {old} in {name} alone is not seen")
    # the brakes must not close between the program's motion and friStart
    idle = re.search(r"idle_brakes_s = ([\d.]+)", (root / "sim_hal/emulator/krc/krc_emulator.hpp").read_text())
    figures = krl_figures(krl)
    if not idle or figures["kQuality_s"] + figures["kCommand_s"] >= float(idle.group(1)):
        bad.append("colift.src waits longer after its motion than brakes stay open")
    data = root / "config/krl/colift.dat"
    if not data.exists() or not re.search(r"^DEFDAT colift\b.*^ENDDAT", data.read_text(), re.S | re.M):
        bad.append("config/krl/colift.dat: no data list of the same name")
    print("\n".join(bad) or "config/krl/colift.src and the emulator's program agree")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
