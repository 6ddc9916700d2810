#!/usr/bin/env python3
"""What README.md and docs/ show is carried out, and it prints what they say that it prints.

    tests/docs/check_samples.py PROGRAM [--root FOLDER] [--python FOLDER] [--part I/N] [README.md docs/tour.md ...]

Each document gets an empty folder with `tests` and `config` in it; its blocks are carried out in the order of the page:

- Lines that begin with `build/colift` or `colift` run the program and have to succeed. A command that serves (`--view`, `emulate`,
  `ros2`) is ended as Ctrl-C ends it when its block ends, or when it has been heard of.
- An indented block that begins with a prompt ("    $ build/colift ...") is compared too: `$ cat NAME` writes the lines that follow
  into a file of that name, and each line below any other command has to occur in what that prints. A block may leave lines out, cut
  a line's end off, and put in one line what the program breaks into several. Numbers may differ by a twentieth, or by two of their
  last digit: they depend on compiler and libraries.
- A block of Python runs with the module in --python, where there is one.

What is not carried out is in NOT_HERE, with the reason. Ends with 0 when all of it holds, 1 with what does not, 2 when there was nothing
to carry out.
"""

import argparse
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time

NOT_HERE = [  # of a command's text; the reason
    (r"--robot (rig|my_robot)\.yaml|--samples", "needs a robot, or what was recorded on one"),
    (r"\bhal camera record\b|\bhal arm state\b", "needs a device"),
    (r"\bFRAME\b|\bNAME\b|\[--", "stands for others of its kind"),
    (r"\bcolift experiment\b", "a campaign: the test experiments_small runs each of them with few trials"),
    (r"\bcalibrate --robot emulated\b", "minutes of real time"),
    (r"--robot emulated", "in real time, alone: the test dds_arm runs it so"),
    (r"\blog snapshot\b", "needs a run at its side: the test docs_schemas has one"),
]
SYNTHETIC = """import colift
scene = colift.synthetic_scene()
scene["frame"].write("before.png"), scene["frame_with_partner"].write("with_partner.png")
"""
SERVES = r"--view\b|\bcolift emulate\b|\bcolift ros2\b"
NUMBER = r"[-+]?\d+(?:\.\d+)?"
LIMIT_S = 600
TRIES = 30


def blocks(text):
    """(number of the first line, lines without their indent, language) of each indented or fenced block."""
    block, start, fence = [], 0, None
    for number, line in enumerate(text.splitlines() + [""], 1):
        if line.startswith("```"):
            if fence is None:
                fence, start, block = line[3:].strip(), number + 1, []
            else:
                yield start, block, fence
                fence, block = None, []
        elif fence is not None:
            block.append(line)
        elif line.startswith("    "):
            start = start if block else number
            block.append(line[4:])
        elif block:
            yield start, block, ""
            block = []


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


class Reader:
    """Carries out the blocks of one document in a folder of its own."""

    def __init__(self, name, work, program, python):
        self.name, self.work, self.program, self.python = name, work, program, python
        self.wrong, self.done, self.left = [], 0, {}
        self.seconds = {}

    def complain(self, number, text):
        self.wrong.append(f"{self.name}:{number}: {text}")

    def words_of(self, command):
        """The command with the program and the module of this build; nothing when it is none of ours."""
        environment = dict(os.environ, HOME=str(self.work), XDG_STATE_HOME=str(self.work / ".state"))
        words = shlex.split(command, comments=True)
        while words and re.fullmatch(r"\w+=\S*", words[0]):
            key, _, value = words.pop(0).partition("=")
            environment[key] = str(self.python) if key == "PYTHONPATH" and self.python else value
        if words and words[0] in ("build/colift", "colift"):
            return [str(self.program), *words[1:]], environment
        if words and words[0] == "/usr/bin/python3" and self.python:
            return words, environment
        return None, environment

    def serve(self, number, command):
        """Starts a command that serves, waits for its first line, and ends it by SIGINT."""
        words, environment = self.words_of(command)
        for _ in range(TRIES):  # another test of this machine may have the port that a page shows
            said = subprocess.Popen(words, cwd=self.work, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            first = said.stdout.readline()
            if "in use" not in first:
                break
            said.wait()
            time.sleep(1)
        said.send_signal(signal.SIGINT)
        try:
            said.communicate(timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            said.kill()
            self.complain(number, f"does not end: {command}")
        if not first or said.returncode not in (0, 130):
            self.complain(number, f"ended with {said.returncode}: {command}: {first.strip()}")

    def run(self, number, command, refused=False):
        """What the command prints; nothing when it is not carried out. It has to succeed, or may refuse (1)."""
        command = command.partition(" #")[0].strip()
        reason = next((reason for pattern, reason in NOT_HERE if re.search(pattern, command)), None)
        if reason:
            self.left[command] = reason
            return None
        began = time.monotonic()
        printed = ""
        if re.search(SERVES, command):
            self.serve(number, command)
        else:
            for part in command.split("&&"):
                part, _, into = part.partition(" > ")
                words, environment = self.words_of(part)
                if words is None:
                    return None
                done = subprocess.run(words, cwd=self.work, env=environment, capture_output=True, text=True, timeout=LIMIT_S)
                printed += done.stderr + "\n" + done.stdout
                if into:
                    (self.work / into.split()[0]).write_text(done.stdout)
                if done.returncode != 0 and not (done.returncode == 1 and refused):
                    self.complain(number, f"ended with {done.returncode}: {command}: {one_line(done.stderr)[-200:]}")
        self.done += 1
        self.seconds[command] = time.monotonic() - began
        return one_line(printed)

    def block(self, start, lines, language):
        if language == "python":
            if self.python:
                self.run_python(start, "\n".join(lines))
            return
        shows_output = lines[0].startswith("$ ")
        printed, file = None, None
        for number, line in enumerate(lines, start):
            if line.startswith("$ cat "):
                file = self.work / line.removeprefix("$ cat ").strip()
                file.write_text("")
            elif line.startswith("$ ") or (not shows_output and re.match(r"(build/)?colift ", line)):
                file = None
                shows_refusal = any(re.match(r"refused|aborted", shown) for shown in lines)
                printed = self.run(number, line.removeprefix("$ "), shows_refusal)
            elif file is not None:
                file.write_text(file.read_text() + line + "\n")
            elif shows_output and printed is not None and not occurs(line, printed):
                self.complain(number, f"not printed: {line.strip()}")

    def run_python(self, number, text):
        """Python finds the frames that a page speaks of: a scene without and with its partner."""
        make = f"import sys; sys.path.insert(0, {str(self.python)!r}); exec({SYNTHETIC!r})\n"
        done = subprocess.run(["/usr/bin/python3", "-c", make + text], cwd=self.work, capture_output=True, text=True, timeout=LIMIT_S)
        self.done += 1
        if done.returncode != 0:
            self.complain(number, f"the block of Python: {one_line(done.stderr)[-300:]}")


def documents(root, named, part):
    everything = [pathlib.Path(n) for n in named] or [pathlib.Path("README.md"), *sorted(p.relative_to(root) for p in (root / "docs").rglob("*.md"))]
    index, count = part
    return everything[index::count]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("documents", nargs="*")
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path(__file__).parents[2])
    parser.add_argument("--python", type=pathlib.Path, help="the folder of the module colift")
    parser.add_argument("--part", type=lambda text: tuple(map(int, text.split("/"))), default=(0, 1), help="every N-th document from I on")
    args = parser.parse_args()
    root, program = args.root.resolve(), args.program.resolve()
    wrong, done, left = [], 0, {}
    for name in documents(root, args.documents, args.part):
        with tempfile.TemporaryDirectory() as folder:
            work = pathlib.Path(folder)
            for link in ("tests", "config"):  # the paths that samples name
                if (root / link).exists():  # an installation has neither
                    (work / link).symlink_to(root / link)
            reader = Reader(name, work, program, args.python.resolve() if args.python else None)
            for start, lines, language in blocks((root / name).read_text(encoding="utf-8")):
                if lines:
                    reader.block(start, lines, language)
        wrong, done, left = wrong + reader.wrong, done + reader.done, {**left, **reader.left}
        for command, seconds in reader.seconds.items():
            print(f"{seconds:6.1f} s  {name}: {command}")
    for command, reason in left.items():
        print(f"not here: {command.strip()}: {reason}")
    print("\n".join([*wrong, f"{done} carried out, {len(left)} not here, {len(wrong)} wrong"]))
    return 1 if wrong else 0 if done else 2


if __name__ == "__main__":
    sys.exit(main())
