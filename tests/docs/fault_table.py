#!/usr/bin/env python3
"""docs/faults.md: which test meets which fault in which state, from what the test programs say of themselves.

    tests/docs/fault_table.py write|check BUILD_FOLDER docs/faults.md

Whole lifts print the faults that they inject (test case "[.fault-table]", tests/support/fault_table.hpp); tests of one device carry
"row N" in their name; what neither can say stands in fault_catalogue.py. A name there that no program lists is an error.

Ends with 0; 1 where the page differs, or a cell has neither a test nor a reason; 2 when it was called wrongly.
"""
import pathlib
import re
import subprocess
import sys

from fault_catalogue import FAULTS, REASONS, STATES

HEAD = """# Faults: what is tested, and in which state

Written by `tests/docs/fault_table.py write build docs/faults.md` from the test programs; do not edit. Reactions: [task.md](task.md).

- **●** a whole lift meets the fault there in every test run; **○** with `COLIFT_THOROUGH=1` only
- **alone**: tests of the device, guard or monitor alone
"""


def programs(folder):
    """Test programs: those that understand Catch2's listing."""
    names = sorted(p for p in folder.iterdir() if p.is_file() and p.stat().st_mode & 0o111 and
                   (p.name.startswith("unit_") or p.name.endswith("lifts") or p.name in ("scenarios", "stories", "contract")))
    if not names:
        sys.exit(2)
    return names


def listed(folder):
    """(names of all tests, {(row, column): "●" or "○"})"""
    names, cells = set(), {}
    column = {state: c for c, states in STATES.items() for state in states}
    for program in programs(folder):
        out = subprocess.run([program, "--list-test-names-only"], capture_output=True, text=True, timeout=60).stdout
        names |= {line.strip() for line in out.splitlines()}
        if not program.name.endswith("lifts") and program.name not in ("scenarios", "stories"):
            continue
        out = subprocess.run([program, "[.fault-table]"], capture_output=True, text=True, timeout=60).stdout
        for line in out.splitlines():
            if not line.startswith("fault\t"):
                continue
            _, row, state, when = line.split("\t")
            key = int(re.match(r"\d+", row)[0]), column[state]
            if when == "always" or cells.get(key) != "●":
                cells[key] = "●" if when == "always" else "○"
    return names, cells


def rows_of(name):
    return {int(n) for text in re.findall(r"\brows? (\d+(?:(?:, | and )\d+)*)", name) for n in re.findall(r"\d+", text)}


def page(names, cells):
    alone = {}
    for name in names:
        for row in rows_of(name):
            alone[row] = alone.get(row, 0) + 1
    wrong, lines, used = [], [HEAD], set()
    for fault in FAULTS:
        if len(fault) == 1:
            lines += [f"\n## {fault[0][0].upper() + fault[0][1:]}\n",
                      "| | fault | reaction | alone | " + " | ".join(STATES) + " |", "|---|---|---|---|" + "---|" * len(STATES)]
            continue
        number, what, reaction, tests, reasons = fault
        wrong += [f"row {number}: no test is called \"{t}\"" for t in tests if t not in names]
        count = alone.get(number, 0) + len(tests)
        row = []
        for state in STATES:
            cell = cells.get((number, state)) or reasons.get(state) or ("d" if count else "n")
            used.add(cell)
            row.append(cell)
        lines.append(f"| {number} | {what} | {reaction} | {count or ''} | " + " | ".join(row) + " |")
    lines += ["\n## Why a cell has no whole lift\n"] + [f"- **{k}**: {v}" for k, v in REASONS.items() if k in used]
    return "\n".join(lines) + "\n", wrong


def main():
    if len(sys.argv) != 4 or sys.argv[1] not in ("write", "check"):
        print(__doc__)
        return 2
    text, wrong = page(*listed(pathlib.Path(sys.argv[2])))
    doc = pathlib.Path(sys.argv[3])
    for line in wrong:
        print(line)
    if sys.argv[1] == "write":
        doc.write_text(text)
    elif not doc.exists() or doc.read_text() != text:
        print(f"{doc} is not what the tests say: run tests/docs/fault_table.py write {sys.argv[2]} {doc}")
        return 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
