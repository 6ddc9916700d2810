#!/usr/bin/env python3
"""Whether people who watch disturb the arm: a run on the emulated rig (real drivers, real time) with its live view,
first with nobody, then with 20 viewers. One of them never reads, one floods; both come back when they are closed.

Prints for both how long the arm's answers took and how many came too late, beside the cycles that the emulated
controller itself began late, for which the machine is to blame, or, where `fri.cpu` has both on one processor, a slow answer: look at the times. Means something only on a machine with
nothing else to do. Standard library only. Usage: viewers.py COLIFT [--robot FILE] [--viewers N] [--seed N]
Exit: 0 no more missed with viewers than without; 1 more; 2 a run failed or was no whole lift.
"""

import argparse
import base64
import json
import os
import pathlib
import re
import selectors
import signal
import socket
import struct
import subprocess
import sys
import threading
import time

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"
CONTINUED, TEXT, PONG = 0, 1, 10


def frame(kind, payload):
    """A masked frame of a client (RFC 6455)."""
    mask = os.urandom(4)
    if len(payload) < 126:
        head = struct.pack(">BB", 0x80 | kind, 0x80 | len(payload))
    else:
        head = struct.pack(">BBH", 0x80 | kind, 0x80 | 126, len(payload))
    return head + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload))


def connect(port, buffer=None):
    """A client after its handshake, and what came behind the server's answer."""
    s = socket.socket()
    if buffer:
        s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    s.settimeout(5)
    s.connect(("127.0.0.1", port))
    key = base64.b64encode(os.urandom(16)).decode()
    s.sendall((f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
               f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
               "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n").encode())
    data = b""
    while b"\r\n\r\n" not in data:
        more = s.recv(4096)
        if not more:
            raise ConnectionError("closed before the handshake")
        data += more
    head, rest = data.split(b"\r\n\r\n", 1)
    if b" 101 " not in head.split(b"\r\n")[0]:
        raise ConnectionError(head.decode(errors="replace"))
    return s, rest


def channels(port):
    """The ids that the server announces."""
    s, data = connect(port)
    text = b""
    while True:
        while len(data) < 10:
            data += s.recv(65536)
        size, at = data[1] & 127, 2
        if size == 126:
            size, at = struct.unpack_from(">H", data, 2)[0], 4
        elif size == 127:
            size, at = struct.unpack_from(">Q", data, 2)[0], 10
        while len(data) < at + size:
            data += s.recv(65536)
        if data[0] & 15 in (CONTINUED, TEXT):
            text += data[at:at + size]
            if data[0] & 0x80:  # the last frame of a message
                message, text = json.loads(text), b""
                if message["op"] == "advertise":
                    s.close()
                    return [c["id"] for c in message["channels"]]
        data = data[at + size:]


class Viewers(threading.Thread):
    """All clients of one run, in one thread."""

    def __init__(self, port, count):
        super().__init__()
        self.port, self.count = port, count
        self.going, self.bytes, self.closed = True, 0, {"reader": 0, "deaf": 0, "flood": 0}

    def run(self):
        ids = channels(self.port)
        subscribe = frame(TEXT, json.dumps(
            {"op": "subscribe", "subscriptions": [{"id": i, "channelId": i} for i in ids]}).encode())
        nonsense = frame(TEXT, b"{}") * 500
        kinds = {i: "reader" for i in range(self.count)}
        kinds[0], kinds[1] = "deaf", "flood"
        sockets, back_at = {}, {i: 0.0 for i in kinds}
        readers = selectors.DefaultSelector()
        spoken = time.monotonic()

        def drop(i):
            s = sockets.pop(i)
            if kinds[i] == "reader":
                readers.unregister(s)
            s.close()
            self.closed[kinds[i]] += 1
            back_at[i] = time.monotonic() + 0.1

        while self.going:
            now = time.monotonic()
            for i, kind in kinds.items():
                if i in sockets or now < back_at[i]:
                    continue
                try:
                    s, _ = connect(self.port, 4096 if kind == "deaf" else None)
                    s.sendall(subscribe)
                except OSError:
                    back_at[i] = now + 0.5
                    continue
                s.setblocking(False)
                sockets[i] = s
                if kind == "reader":
                    readers.register(s, selectors.EVENT_READ, i)
            for key, _ in readers.select(0.02):
                try:
                    data = key.fileobj.recv(1 << 20)
                except BlockingIOError:
                    continue
                except OSError:
                    data = b""
                self.bytes += len(data)
                if not data:
                    drop(key.data)
            for i in [i for i in sockets if kinds[i] == "flood"]:
                try:
                    sockets[i].send(nonsense)
                except BlockingIOError:
                    pass
                except OSError:
                    drop(i)
            if now - spoken > 2.0:  # who says nothing is asked, and these do not listen for questions
                spoken = now
                for i in [i for i in sockets if kinds[i] != "flood"]:
                    try:
                        # the deaf one is only looked at: is it still there?
                        sockets[i].send(frame(PONG, b"")) if kinds[i] == "reader" else sockets[i].getpeername()
                        if sockets[i].getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
                            drop(i)
                    except OSError:
                        drop(i)
        for s in sockets.values():
            s.close()


def run(options, viewers):
    """The document of one run, and who watched."""
    child = subprocess.Popen([options.colift, "run", "--robot", options.robot, "--seed", str(options.seed), "--view",
                              "0", "--json", "--quiet"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    crowd, said = None, ""
    for line in child.stderr:
        said += line
        found = re.search(r"live view: http://127\.0\.0\.1:(\d+)/", line)
        if found:
            if viewers:
                crowd = Viewers(int(found.group(1)), viewers)
                crowd.start()
            break
    # the rest of what it says must not fill the pipe
    rest = []
    reader = threading.Thread(target=lambda: rest.append(child.stderr.read()), daemon=True)
    reader.start()
    document = child.stdout.readline()
    if crowd:
        crowd.going = False
        crowd.join()
    child.send_signal(signal.SIGINT)
    child.wait(20)
    reader.join(5)
    if not document:
        print("viewers: the run failed: " + (said + "".join(rest)).strip(), file=sys.stderr)
        sys.exit(2)
    return json.loads(document), crowd


def line(name, document):
    link = document["arm_link"]
    answer, krc = link["answer_us"], link.get("controller", {})
    return (f"{name:<14}{document['outcome']:<9}{link['cycles']:>8}{answer['p50']:>7}{answer['p99']:>7}"
            f"{answer['p999']:>8}{answer['worst']:>8}{krc.get('missed_in_command', 0):>8}{krc.get('late_cycles', 0):>12}"
            f"{krc.get('worst_late_ms', 0.0):>12.1f}")


def in_command(document):
    """Missed answers while the controller took commands; before, a client that is not there yet misses many."""
    return document["arm_link"].get("controller", {}).get("missed_in_command", 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("--robot", default=str(CONFIG / "emulated.yaml"))
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    print(f"{'':<14}{'':<9}{'cycles':>8}{'p50':>7}{'p99':>7}{'p99.9':>8}{'worst':>8}{'missed':>8}{'late cycles':>12}"
          f"{'worst (ms)':>12}\n{'':<31}{'answer (us)':>17}", flush=True)
    alone, _ = run(options, 0)
    print(line("nobody", alone), flush=True)
    watched, crowd = run(options, options.viewers)
    print(line(f"{options.viewers} viewers", watched))
    print(f"they got {crowd.bytes / 1e6:.0f} MB; closed: {crowd.closed['flood']} times who floods, "
          f"{crowd.closed['deaf']} times who never reads, {crowd.closed['reader']} others")
    for name, document in (("nobody", alone), ("viewers", watched)):
        if document["outcome"] != "lifted":
            print(f"with {name} it was no whole lift: {document['because']}")
    more = in_command(watched) - in_command(alone)
    print(f"missed while the controller took commands: {in_command(alone)} with nobody, {in_command(watched)} with viewers")
    if "lifted" != alone["outcome"] or "lifted" != watched["outcome"]:
        sys.exit(2)
    sys.exit(1 if more > 0 else 0)


if __name__ == "__main__":
    main()
