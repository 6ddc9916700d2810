#!/usr/bin/env python3
"""Every command line of the program that a document shows has verbs and options that the program has.

    tests/docs/check_commands.py PROGRAM [ROOT]

Looked at are `inline code` and code blocks of all *.md files but the changelog: what begins with `colift` or `build/colift`. Each verb has to be in
`--help` of the one before, each option in that of the last verb. Values are not judged, and nothing is carried out.

Ends with 0 when all of it holds, 1 with the places where it does not, 2 when no command was found.
"""

import functools
import pathlib
import re
import subprocess
import sys

LEFT_OUT = {"build", ".deps", "node_modules", ".git", "out", "CHANGELOG.md"}  # which tells of what was
COMMAND = re.compile(r"(?:^|[;&|] )(?:sudo |[A-Z_]+=\S+ )*(?:build/)?colift((?: [^`#|;&>()\n]+)?)")


def code_of(text):
    """(line number, code) of every code line and inline span."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif fenced or line.startswith("    "):
            yield number, line.strip().removeprefix("$ ")
        else:
            for span in re.findall(r"`([^`]+)`", line):
                yield number, span


@functools.lru_cache(maxsize=None)
def help_of(program, verbs):
    """(its subcommands, the text) of a command."""
    done = subprocess.run([program, *verbs, "--help"], capture_output=True, text=True, timeout=60)
    below = re.search(r"^(?:Subcommands|Commands):\n((?: .*\n?)+)", done.stdout, re.M)
    names = re.findall(r"^  ([a-z][a-z0-9-]*)", below.group(1), re.M) if below else []
    return frozenset(names), done.stdout


def wrong_in(program, words):
    """What is wrong with the words after the program's name; None: nothing."""
    verbs, options = [], []
    names = help_of(program, ())[0]
    for word in words:
        if word.startswith("--"):
            options.append(re.split(r"[=\]]", word)[0])
        elif names and re.fullmatch(r"[a-z][a-z0-9-]+", word) and not options:
            if word not in names:
                return f'"{" ".join(["colift", *verbs])}" has no "{word}"'
            verbs.append(word)
            names = help_of(program, tuple(verbs))[0]
    text = help_of(program, tuple(verbs))[1]
    if verbs[:1] == ["check"] and "--for" in options:
        return None  # with all options of the command it is for
    for option in options:
        if not re.search(re.escape(option) + r"(?![a-z0-9-])", text):
            return f'"{" ".join(["colift", *verbs])}" has no {option}'
    return None


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    root = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else pathlib.Path(__file__).parents[2]).resolve()
    found = wrong = 0
    for path in sorted(root.rglob("*.md")):
        name = path.relative_to(root)
        if LEFT_OUT & set(name.parts):
            continue
        for number, code in code_of(path.read_text(encoding="utf-8")):
            for match in COMMAND.finditer(code):
                words = match.group(1).split()
                if not words:
                    continue
                found += 1
                reason = wrong_in(program, words)
                if reason:
                    print(f"{name}:{number}: {reason}")
                    wrong += 1
    print(f"{found} command lines, {wrong} of them not the program's")
    return 2 if found == 0 else int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
