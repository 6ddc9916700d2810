"""What walk_bring_up.py starts: commands and emulators as children whose lines can be waited for, each wait with an end."""

import json
import os
import pty
import re
import signal
import socket
import subprocess
import threading
import time

LINE_S = 120.0  # until a line comes; reached only when the walk fails
END_S = 400.0  # until a command ends; likewise
KEY_S = 0.1  # a key that is held down repeats


class Failure(Exception):
    """Something is not as the document says."""


class TooLate(Failure):
    """What a person does came at another time than the walk meant: this machine had no time."""


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Program:
    """A child; `lines` is all that it has printed on both outputs."""

    def __init__(self, words, folder, terminal=False):
        self.words, self.lines, self.news = words, [], threading.Condition()
        environment = {**os.environ, "HOME": str(folder), "XDG_STATE_HOME": str(folder / ".state")}
        self.master = None
        if terminal:
            self.master, slave = pty.openpty()
            self.child = subprocess.Popen(words, cwd=folder, env=environment, stdin=slave, stdout=slave, stderr=slave)
            os.close(slave)
            source = self.master
        else:
            self.child = subprocess.Popen(words, cwd=folder, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                          stderr=subprocess.STDOUT)
            source = self.child.stdout.fileno()
        self.reader = threading.Thread(target=self._read, args=(source,), daemon=True)
        self.reader.start()

    def _read(self, source):
        rest = b""
        while True:
            try:
                got = os.read(source, 65536)
            except OSError:  # of a terminal whose other end is closed
                got = b""
            *whole, rest = (rest + got).split(b"\n")
            if not got and rest:
                whole.append(rest)
            with self.news:
                self.lines += [line.decode(errors="replace").rstrip("\r") for line in whole] + ([] if got else [None])
                self.news.notify_all()
            if not got:
                return

    def text(self):
        with self.news:
            return "\n".join(line for line in self.lines if line is not None)

    def seen(self, pattern):
        return re.search(pattern, self.text(), re.M) is not None

    def wait_for(self, pattern, after=0):
        """A line that comes, or has come behind the first `after` lines."""
        def found():
            return any(line is not None and re.search(pattern, line) for line in self.lines[after:])

        with self.news:
            self.news.wait_for(lambda: found() or None in self.lines, LINE_S)
            if not found():
                raise Failure(f"waited for a line with {pattern!r}")

    def wait_for_news(self, limit_s):
        with self.news:
            before = len(self.lines)
            self.news.wait_for(lambda: len(self.lines) > before or None in self.lines, limit_s)

    def type(self, text):
        try:
            if self.master is not None:
                os.write(self.master, text.encode())
            else:
                self.child.stdin.write(text.encode())
                self.child.stdin.flush()
        except OSError:
            pass  # it has ended: that is seen at its end

    def interrupt(self):
        self.child.send_signal(signal.SIGINT)

    def hold_space(self):
        """The person of `colift recover`: holds the space bar down, and opens the hand when asked."""
        self.wait_for("hold SPACE")
        end, answered = time.monotonic() + END_S, 0
        while self.child.poll() is None and time.monotonic() < end:
            asked = self.text().count("y: open the hand")
            self.type("y" if asked > answered else " ")
            answered = asked
            self.wait_for_news(KEY_S)

    def end(self, limit_s=END_S):
        """Its exit code."""
        if self.master is None:
            self.child.stdin.close()
        try:
            code = self.child.wait(limit_s)
        except subprocess.TimeoutExpired:
            raise Failure(f"did not end within {limit_s:.0f} s") from None
        self.reader.join(LINE_S)
        if self.master is not None:
            os.close(self.master)
            self.master = None
        return code

    def kill(self):
        if self.child.poll() is None:
            self.child.kill()
            self.child.wait()


class FarEnd(Program):
    """`colift emulate WORDS`, ready."""

    def __init__(self, colift, words, folder):
        super().__init__([colift, "emulate", *words, "--json"], folder)
        try:
            self.wait_for(r"^ready: ")
        except Failure as e:
            self.kill()  # another program may have taken its port meanwhile
            raise (TooLate if "in use" in self.text() else Failure)(f"emulate {' '.join(words)}: {e}; it printed:\n{self.text()}") from None
        self.ready = next(line for line in self.lines if line and line.startswith("ready: "))

    def report(self):
        """Ends it; its document."""
        if self.child.poll() is None:
            self.interrupt()
        self.end(60.0)
        for line in reversed(self.lines):
            if line and line.startswith("{"):
                return json.loads(line)
        return {}


def worst_late_ms(report):
    """How late an emulator was by its own account, because the machine did not run it."""
    parts = [report, report.get("arm", {}), report.get("hand", {})]
    return max(float(part.get("timing", {}).get("worst_late_ms", 0.0)) for part in parts)


def rules_broken(report):
    """What the program under test did wrong in the eyes of an emulator."""
    parts = [report, report.get("arm", {}), report.get("hand", {})]
    return [f"{rule['rule']}: {rule['because']}" for part in parts for rule in part.get("broken_rules", [])]


class Pulse:
    """Wakes regularly, and knows when it was late: a machine that stands still stops this script too."""

    EVERY_S = 0.02
    LATE_S = 0.01

    def __init__(self):
        self.late, self._over = [], threading.Event()
        threading.Thread(target=self._beat, daemon=True).start()

    def _beat(self):
        last = time.monotonic()
        while not self._over.wait(self.EVERY_S):
            now = time.monotonic()
            if now - last - self.EVERY_S > self.LATE_S:
                self.late.append((now, now - last - self.EVERY_S))
            last = now

    def worst_ms(self, since):
        return 1e3 * max((late for at, late in list(self.late) if at >= since), default=0.0)

    def stop(self):
        self._over.set()
