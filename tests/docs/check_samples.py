#!/usr/bin/env python3
"""What README.md shows of the program's output is what the program prints.

    tests/docs/check_samples.py PROGRAM [ROOT]

Every indented block that begins with a prompt ("    $ build/colift ...") is carried out: `$ cat NAME` writes the lines that follow into
a file of that name, `$ build/colift ...` runs the program, and each line below it has to occur in what it prints. A block may leave
lines out, cut a line's end off, and put in one line what the program breaks into several. Numbers may differ by a twentieth, or by
two of their last digit: they depend on compiler and libraries.

Ends with 0 when all of it holds, 1 with the lines that do not occur, 2 when no sample was found.
"""

import argparse
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile


def samples(text):
    """Blocks of (number of the first line, lines without their indent)."""
    block, start = [], 0
    for number, line in enumerate(text.splitlines() + [""], 1):
        if line.startswith("    "):
            if not block:
                start = number
            block.append(line[4:])
            continue
        if block and block[0].startswith("$ "):
            yield start, block
        block = []


NUMBER = r"[-+]?\d+(?:\.\d+)?"


def one_line(text):
    return re.sub(r"\s+", " ", text).strip()


def near(shown, printed):
    last_digit = 10.0 ** -len(shown.partition(".")[2])
    return abs(float(shown) - float(printed)) <= max(0.05 * abs(float(printed)), 2.01 * last_digit)


def occurs(line, printed):
    """Whether the line is in what was printed, its numbers about as they are there."""
    line = one_line(line)
    numbers = re.findall(NUMBER, line)
    pattern = f"({NUMBER})".join(re.escape(text) for text in re.split(NUMBER, line))
    return any(all(map(near, numbers, match.groups())) for match in re.finditer(pattern, printed))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("root", nargs="?", type=pathlib.Path, default=pathlib.Path(__file__).parents[2])
    args = parser.parse_args()
    root, program = args.root.resolve(), args.program.resolve()
    wrong = shown = 0
    with tempfile.TemporaryDirectory() as work:
        for name in ("tests", "config"):  # the paths that samples name
            (pathlib.Path(work) / name).symlink_to(root / name)
        for start, block in samples((root / "README.md").read_text(encoding="utf-8")):
            printed, file = None, None
            for number, line in enumerate(block, start):
                if line.startswith("$ cat "):
                    file = pathlib.Path(work) / line.removeprefix("$ cat ").strip()
                    file.write_text("")
                elif line.startswith("$ build/colift"):
                    file = None
                    words = shlex.split(line.removeprefix("$ "))
                    done = subprocess.run([program, *words[1:]], cwd=work, capture_output=True, text=True, timeout=300)
                    printed = one_line(done.stderr + "\n" + done.stdout)
                    shown += 1
                elif file is not None:
                    file.write_text(file.read_text() + line + "\n")
                elif printed is not None and not occurs(line, printed):
                    print(f"README.md:{number}: not printed: {line.strip()}")
                    wrong += 1
    print(f"{shown} commands carried out, {wrong} lines that they do not print")
    return 2 if shown == 0 else int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
