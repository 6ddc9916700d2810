#!/usr/bin/env python3
"""Counts the instructions of fixed pieces of work and compares them with instructions.json.

    tests/instructions/instructions.py build/count_work               # compares; more than 10 % more fails
    tests/instructions/instructions.py build/count_work --update      # writes the file: a commit says why
    tests/instructions/instructions.py build/count_work NAME...       # these only

Instructions, unlike seconds, hardly depend on what else the machine does. Needs valgrind.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FILE = pathlib.Path(__file__).with_name("instructions.json")
TOLERANCE = 0.10
SKIPPED = 77


def count(program, name):
    """Instructions of one work (millions). Raises RuntimeError with what the program said."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=colift_counted",
                   f"--callgrind-out-file={folder}/out", program, name]
        # the same on every machine: an environment of another size moves the stack
        done = subprocess.run(command, capture_output=True, text=True, timeout=600,
                              env={"PATH": os.environ["PATH"], "LC_ALL": "C"})
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or not found or int(found.group(1)) == 0:
        raise RuntimeError(f"{name}: could not be counted: {done.stderr[-600:]}")
    return int(found.group(1)) / 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("name", nargs="*")
    parser.add_argument("--update", action="store_true", help="write the counts to instructions.json")
    args = parser.parse_args()
    if not shutil.which("valgrind"):
        print("valgrind is missing: tools/setup --dev installs it")
        return SKIPPED
    listed = dict(line.split("\t") for line in
                  subprocess.run([args.program], capture_output=True, text=True, check=True).stdout.splitlines())
    names = args.name or list(listed)
    known = json.loads(FILE.read_text()) if FILE.exists() else {}
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        counts = dict(zip(names, pool.map(lambda name: count(args.program, name), names)))

    slower = []
    print(f"{'work':24} {'million':>9} {'before':>9} {'change':>7}  what")
    for name in names:
        before = known.get(name)
        change = f"{100 * (counts[name] / before - 1):+.1f} %" if before else "new"
        print(f"{name:24} {counts[name]:9.2f} {before if before else float('nan'):9.2f} {change:>7}  {listed.get(name, '')}")
        if before is None or counts[name] > before * (1 + TOLERANCE):
            slower.append(name)
    if args.update:
        known.update({name: round(counts[name], 2) for name in names})
        FILE.write_text(json.dumps({name: known[name] for name in listed if name in known}, indent=1) + "\n")
        return 0
    gone = [] if args.name else [name for name in known if name not in listed]
    if slower or gone:
        print("\nmore than 10 % more instructions, or unknown: " + ", ".join(slower + gone))
        print("make it as fast again, or run with --update and say in the commit why it may cost more")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
