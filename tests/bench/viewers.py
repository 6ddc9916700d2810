#!/usr/bin/env python3
"""Whether people who watch disturb the arm: runs on the emulated rig (real drivers, real time) with its live view, in
pairs: with nobody, and with 20 viewers. One of them never reads, one floods; both come back when they are closed.

Prints for both how long the arm's answers took, how many were missed while the emulated controller took commands, and
how many of these are the program's own: `standstill` watches the processors meanwhile (tests/support/standstill.py).
Means something only on a machine with nothing else to do. A minute a pair.
With --ros2 the watchers are nodes of ROS 2 instead (`run --ros2`): a flood of garbage on a topic of the run, damaged packets to its ports,
and a subscriber that is stopped and never acknowledges (build/dds_peer of tests/dds).
Usage: viewers.py COLIFT [--cpu N] [--viewers N] [--ros2] [--seed N] [--pairs N]
Exit: 0 in all no more missed with viewers than without, the machine's own ones not counted; 1 more; 2 a run failed or
was no whole lift.
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
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import emulated_robot  # noqa: E402
import standstill  # noqa: E402

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


class HostileNodes:
    """Processes of another implementation of DDS that lie, flood, and fall silent."""

    def __init__(self, peer, domain):
        hostile = (["flood", str(domain), "rt/tf", "tf2_msgs::msg::dds_::TFMessage_"], ["packets", str(domain)])
        dead = ["read", str(domain), "rt/colift/task_status", "colift_msgs::msg::dds_::TaskStatus_"]
        self.nodes = [subprocess.Popen([peer, *words], stdout=subprocess.DEVNULL) for words in (*hostile, dead)]
        self.silence = threading.Timer(8.0, lambda: self.nodes[-1].send_signal(signal.SIGSTOP))
        self.silence.start()

    def end(self):
        self.silence.cancel()
        for node in self.nodes:
            node.kill()
            node.wait()


def run(options, seed, viewers):
    """The document of one run, who watched, and who watched the machine."""
    with standstill.Witness(standstill.beside(options.colift)) as witness:
        document, crowd = watched_run(options, seed, viewers)
    return document, crowd, witness


def watched_run(options, seed, viewers):
    command = [options.colift, "run", "--robot", options.robot, "--seed", str(seed), "--view", "0", "--json", "--quiet"]
    nodes = None
    if options.ros2 and viewers:
        domain = 1 + os.getpid() % 100
        command += ["--ros2", "--ros2-domain", str(domain)]
        nodes = HostileNodes(pathlib.Path(options.colift).resolve().parent / "dds_peer", domain)
    child = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    crowd, said = None, ""
    for line in child.stderr:
        said += line
        found = re.search(r"live view: http://127\.0\.0\.1:(\d+)/", line)
        if found:
            if viewers and not nodes:
                crowd = Viewers(int(found.group(1)), viewers)
                crowd.start()
            break
    # the rest of what it says must not fill the pipe
    rest = []
    reader = threading.Thread(target=lambda: rest.append(child.stderr.read()), daemon=True)
    reader.start()
    document = child.stdout.readline()
    if nodes:
        nodes.end()
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


def missed(document, witness):
    """Answers missed while the controller took commands, and how many of them are not the machine's."""
    spans = standstill.missed(document)
    return len(spans), len(standstill.programs_own(spans, witness.stood))


def line(name, document, witness):
    link = document["arm_link"]
    answer, krc = link["answer_us"], link["controller"]
    all_missed, own = missed(document, witness)
    stood = len([s for s in witness.stood or [] if s[1] - s[0] > 0.001])
    return (f"{name:<14}{document['outcome']:<9}{link['cycles']:>8}{answer['p50']:>7}{answer['p99']:>7}"
            f"{answer['p999']:>8}{answer['worst']:>8}{all_missed:>8}{own:>6}{krc['late_cycles']:>12}"
            f"{stood:>10}{witness.worst_ms or float('nan'):>12.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("colift")
    parser.add_argument("--cpu", type=int, default=-1, help="of the driver and the emulated controller")
    parser.add_argument("--viewers", type=int, default=20)
    parser.add_argument("--ros2", action="store_true", help="hostile nodes of ROS 2 instead of viewers")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--pairs", type=int, default=1)
    options = parser.parse_args()
    if standstill.beside(options.colift) is None:
        print("no standstill beside colift (cmake -DCOLIFT_BENCH=ON, ninja standstill): every miss counts as the "
              "program's own")
    print(f"{'':<14}{'':<9}{'cycles':>8}{'p50':>7}{'p99':>7}{'p99.9':>8}{'worst':>8}{'missed':>8}{'own':>6}"
          f"{'late cycles':>12}{'machine stood still':>22}\n{'':<31}{'answer (us)':>22}{'':>34}"
          f"{'over 1 ms':>12}{'worst (ms)':>11}", flush=True)
    folder = tempfile.TemporaryDirectory(prefix="colift-viewers-")
    options.robot = emulated_robot.write(folder.name, options.cpu)
    total = {"nobody": [0, 0], "viewers": [0, 0]}
    whole = True
    for seed in range(options.seed, options.seed + options.pairs):
        for who, count in (("nobody", 0), ("viewers", options.viewers)):
            document, crowd, witness = run(options, seed, count)
            watchers = "hostile nodes" if options.ros2 else f"{count} viewers"
            print(line(watchers if count else "nobody", document, witness), flush=True)
            if crowd:
                print(f"{'':<14}they got {crowd.bytes / 1e6:.0f} MB; closed: {crowd.closed['flood']} times who floods, "
                      f"{crowd.closed['deaf']} times who never reads, {crowd.closed['reader']} others", flush=True)
            if document["outcome"] != "lifted":
                whole = False
                print(f"{'':<14}no whole lift: {document['because']}", flush=True)
            total[who] = [a + b for a, b in zip(total[who], missed(document, witness))]
    print(f"missed in command: {total['nobody'][0]} with nobody ({total['nobody'][1]} the program's own), "
          f"{total['viewers'][0]} with viewers ({total['viewers'][1]} its own)")
    if not whole:
        sys.exit(2)
    sys.exit(1 if total["viewers"][1] > total["nobody"][1] else 0)


if __name__ == "__main__":
    main()
