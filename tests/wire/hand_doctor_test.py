#!/usr/bin/python3
"""`colift hal hand doctor` end to end: a hand that answers, one with a silent puck, none, and a file that exists.

    hand_doctor_test.py COLIFT
"""

import json
import os
import re
import subprocess
import sys
import tarfile
import tempfile

try:
    import can  # noqa: F401
except ImportError:
    print("SKIPPED: no python-can; tools/setup --dev installs python3-can, for /usr/bin/python3")
    sys.exit(77)

sys.dont_write_bytecode = True  # leaves nothing in the source tree
from hand_client import Emulator

PARTS = {"state.txt", "bus.txt", "config.yaml", "bus.log"}


def doctor(colift, folder, port, name):
    """Exit code, what was said, and the bundle's parts."""
    rig, bundle = os.path.join(folder, "rig.yaml"), os.path.join(folder, name)
    with open(rig, "w") as f:
        f.write(f"arm: fri\nhand: barrett\nemulator: never\nbarrett: {{can: 'socketcand:127.0.0.1:{port}/can0'}}\n")
    done = subprocess.run([colift, "hal", "hand", "doctor", "--robot", rig, "--out", bundle], capture_output=True, text=True,
                          timeout=60)
    parts = {}
    if os.path.exists(bundle):
        with tarfile.open(bundle) as tar:
            parts = {os.path.basename(m.name): tar.extractfile(m).read().decode() for m in tar}
    return done.returncode, done.stdout + done.stderr, parts


def main():
    colift = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        emulator = Emulator(colift, "socketcand:127.0.0.1:0/can0")
        port = re.search(r"port (\d+)", emulator.ready)[1]
        code, said, parts = doctor(colift, folder, port, "good.tar")
        assert code == 0 and set(parts) == PARTS | {"state.json"}, (code, said, set(parts))
        pucks = json.loads(parts["state.json"])
        assert "4 of 4 pucks answer" in parts["state.txt"] and pucks["schema"].startswith("colift.hal.hand"), parts
        assert "socketcand:127.0.0.1:" in parts["config.yaml"], parts["config.yaml"]
        # a frame a line, none of which sets a property: a question is one byte
        frames = re.findall(r"^\(\d+\.\d+\) \S+ ([0-9A-F]+)#([0-9A-F]*)", parts["bus.log"], re.M)
        asked = [data for identifier, data in frames if int(identifier, 16) >> 5 & 0x1F == 0]
        assert len(asked) >= 4 and all(len(data) == 2 for data in asked), parts["bus.log"]
        assert "logged in" not in said and os.listdir(folder).count("good.tar.log") == 0, said

        before = os.stat(os.path.join(folder, "good.tar")).st_mtime_ns
        code, said, _ = doctor(colift, folder, port, "good.tar")
        assert code == 2 and "exists already" in said, (code, said)
        assert os.stat(os.path.join(folder, "good.tar")).st_mtime_ns == before
        report = emulator.end()
        assert report["broken_rules"] == [], report

        emulator = Emulator(colift, "socketcand:127.0.0.1:0/can0", "--fault", "0:silent@F2:60")
        port = re.search(r"port (\d+)", emulator.ready)[1]
        code, said, parts = doctor(colift, folder, port, "silent.tar")
        assert code == 3 and "3 of 4 pucks answer" in parts["state.txt"] and "F2" in said, (code, said, parts)
        emulator.kill()

        code, said, parts = doctor(colift, folder, port, "none.tar")
        assert code == 3 and set(parts) == PARTS and "nobody listens there" in parts["state.txt"], (code, said, parts)
    print("ok")
    return 0


if __name__ == "__main__":
    sys.exit(main())
