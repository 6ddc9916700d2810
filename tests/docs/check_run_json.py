#!/usr/bin/env python3
"""docs/run-json.md names every key that a run prints, and no other.

    tests/docs/check_run_json.py PROGRAM PAGE SCENARIO

Ends with 0 when page and run agree, else 1 with the keys that differ. Rows whose last column names a condition may be absent.
"""

import json
import pathlib
import re
import subprocess
import sys


def page_keys(text):
    """{top key: (names of its inner keys, whether it may be absent)} of the table's rows."""
    keys = {}
    for line in text.splitlines():
        cells = [c.strip() for c in line.split("|")[1:-1]]
        if len(cells) != 3 or not cells[0].startswith("`"):
            continue
        named = re.findall(r"`([a-z_.\[\]]+)`", cells[0])
        for path in named:
            top, _, inner = path.replace("[]", "").partition(".")
            entry = keys.setdefault(top, (set(), cells[2] != ""))
            if inner:
                entry[0].add(inner)
        if len(named) == 1:
            keys[named[0].replace("[]", "").partition(".")[0]][0].update(re.findall(r"`([a-z_]+)`", cells[1]))
    return keys


def main():
    program, page, scenario = sys.argv[1:]
    done = subprocess.run([program, "run", "--scenario", scenario, "--seed", "1", "--json", "--quiet"], capture_output=True, text=True, check=False)
    run = json.loads(done.stdout)
    keys = page_keys(pathlib.Path(page).read_text())
    wrong = [f"{page} does not name {key}" for key in run if key not in keys]
    wrong += [f"a run has no {key}" for key, (_, optional) in keys.items() if key not in run and not optional]
    for key, value in run.items():
        if isinstance(value, list):
            value = value[0] if value else None
        if isinstance(value, dict):
            wrong += [f"{page} does not name {key}.{inner}" for inner in value if inner not in keys.get(key, (set(), 0))[0]]
    print("\n".join(wrong) or f"{len(keys)} keys agree")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
