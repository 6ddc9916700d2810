#!/usr/bin/env python3
"""A recording of OpenNI2 made and used as a user does it: from an emulated device to a file, from the file to what CoLift sees in it.

    oni_recording.py COLIFT

`colift emulate camera` is the device, OpenNI2 records it (`colift hal camera record NAME.oni`) and plays it; one frame of it is kept and looked
at. In real time. Exit code 1 with a line for what did not hold.
"""

import json
import os
import subprocess
import sys
import tempfile

PATIENCE_S = 120.0  # a slow machine makes it slower, not wrong


def main():
    program = sys.argv[1]
    address = f"@colift-oni-{os.getpid()}"
    wrong = []

    def document(*words):
        done = subprocess.run([program, *map(str, words), "--json"], capture_output=True, text=True, timeout=PATIENCE_S)
        print(f"colift {' '.join(map(str, words))}: {done.returncode}")
        if done.returncode != 0:
            wrong.append(f"{words}: exit code {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout) if done.stdout.strip() else {}

    def holds(condition, what):
        if not condition:
            wrong.append(what)

    with tempfile.TemporaryDirectory(prefix="colift-oni-") as folder:
        oni, depth = os.path.join(folder, "table.oni"), os.path.join(folder, "depth.png")
        device = subprocess.Popen([program, "emulate", "camera", "--live", "--address", address, "--scenario", "table"],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            holds(address in device.stdout.readline(), "the emulated camera does not say its address")
            recorded = document("hal", "camera", "record", oni, "--source", f"openni2:emulated:{address}", "--for", 1.5)
        finally:
            device.terminate()
            device.communicate(timeout=PATIENCE_S)
        holds(recorded.get("end") == "done" and recorded.get("serial") == "EMULATED0001", f"recording: {recorded}")
        holds(os.path.exists(oni) and os.path.getsize(oni) > 100_000, "the recording is not there, or next to empty")
        again = subprocess.run([program, "hal", "camera", "record", oni, "--source", "openni2:any"], capture_output=True, text=True)
        holds(again.returncode == 2, "a recording that exists is written over")
        played = document("hal", "camera", "info", "--source", f"openni2:file:{oni}", "--for", 0.7, "--depth", depth)
        holds(played.get("frames", {}).get("handed_out", 0) > 3, f"too few frames of the recording: {played}")
        holds(played.get("process", {}).get("starts") == 1 and played.get("process", {}).get("kills") == 0, f"restarts: {played}")
        for key in ("duplicate", "old", "misdated", "broken", "clock_set"):
            holds(played.get("dropped", {}).get(key) == 0, f"dropped of a recording: {played.get('dropped')}")
        seen = document("look", depth)
        holds(seen.get("ground") and seen.get("target"), f"no ground or no target in a frame of the recording: {str(seen)[:300]}")
    for line in wrong:
        print(f"WRONG: {line}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
