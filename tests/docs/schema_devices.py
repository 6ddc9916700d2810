"""Documents of `colift emulate` and `colift hal`: each device emulated in a process of its own, on free ports, and its verbs against it."""

import json
import os
import re
import signal
import socket
import subprocess

from schema_checker import Emulator, free_port

TRIES = 3
CALIBRATIONS = 8  # of one finger: between its steps two other commands have to be in time


def robot(folder, name, **entries):
    file = folder / f"{name}.yaml"
    file.write_text(json.dumps(entries))
    return file


def ended(c, emulator, what):
    document = emulator.end()
    c.validate("emulate", document, f"colift emulate {what}")
    return document


def arm(c, folder):
    fri = {"address": "127.0.0.1", "port": free_port(socket.SOCK_DGRAM), "krc": "127.0.0.1", "cycle_ms": 4, "first_s": 10}
    file = robot(folder, "arm", arm="fri", fri=fri)
    hal = lambda *words: c.command("hal-arm", "hal", "arm", *words, "--robot", file)
    limits = hal("limits")
    with Emulator(c, "krc", "--plant", "light", "--cycle-ms", 4, "--to", f"127.0.0.1:{fri['port']}", "--fault", "0.1:delay:0.1") as krc:
        state = hal("state", "--for", 0.5)
        hal("hold", "--for", 0.3)
        hal("switch", "position", "joint_impedance", "--for", 0.2)
        hal("move-joint", 1, 2)
        emulated = ended(c, krc, "krc")
    robot(folder, "arm", arm="fri", fri=dict(fri, first_s=0.2))
    hal("hold")  # nobody is there
    if state:
        c.has_to_fail("hal-arm", state, lambda d: d["result"].update(outcome="fine"), "an outcome that does not exist")
        c.has_to_fail("hal-arm", state, lambda d: d["command_mode"].pop("obstacles"), "an arm without its obstacles")
        c.has_to_fail("hal-arm", state, lambda d: d["joints"].pop(), "an arm of six joints")
    c.has_to_fail("hal-arm", limits, lambda d: d.update(verb="bounds"), "a verb that does not exist")
    c.has_to_fail("emulate", emulated, lambda d: d.update(device="plc"), "a device that does not exist")
    c.has_to_fail("emulate", emulated, lambda d: d["packets"].pop("sent"), "a controller that does not say what it sent")


def hand(c, folder):
    """The document of a calibration too: what the fingers press on takes the place of the person who bends one."""
    bus_log, calibration = folder / "bus.log", folder / "scales.yaml"
    with Emulator(c, "hand", "--plant", "light", "--width", 0.1, "--bus", "socketcand:127.0.0.1:0/can0") as pucks:
        can = f"socketcand:127.0.0.1:{re.search(r'port ([0-9]+)', pucks.ready)[1]}/can0"
        file = robot(folder, "hand", hand="barrett", barrett={"can": can})
        hal = lambda *words: c.command("hal-hand", "hal", "hand", *words, "--robot", file, tries=TRIES)
        hal("state")
        hal("watch", "--for", 0.2)  # refused: it does not know its zero
        hal("init", "--yes")
        state = hal("state")
        motion = hal("finger", "F1", 20)
        hal("torque", "F1", 0.3, "--for", 0.2, "--yes")
        hal("velocity", "F2", 20, "--for", 0.3)
        hal("preshape", 10, "--fingers", 15)
        hal("doctor", "--out", folder / "hand.tar")
        for left in reversed(range(CALIBRATIONS)):
            hal("open", "--yes")
            refused = calibrate(c, file, calibration, lambda nm: hal("close", "--torque", nm, "--bus-log", bus_log))
            if not refused:
                break
            if not left:
                c.wrong.append("colift hal hand calibrate: no document: " + refused[-300:])
        hal("grip", "--for", 0.2)
        hal("emergency-open", "--yes")
        ended(c, pucks, "hand")
    replay = c.command("hal-hand", "hal", "hand", "replay", bus_log)
    if state:
        c.has_to_fail("hal-hand", state, lambda d: d["pucks"].pop(), "a hand of three pucks")
        c.has_to_fail("hal-hand", state, lambda d: d["result"].update(moved=True), "a state that moved the hand")
    if motion:
        c.has_to_fail("hal-hand", motion, lambda d: d.update(finger="spread"), "a finger that is none")
    if replay:
        c.has_to_fail("hal-hand", replay, lambda d: d.update(verb="play"), "a verb that does not exist")
        c.has_to_fail("hal-hand", replay, lambda d: d.pop("driver"), "a replay that says nothing of the driver")
    return calibration


def calibrate(c, file, out, press):
    """Returns what the program said instead of a document, "" with one."""
    words = ["hal", "hand", "calibrate", "F1", "--torques", "0.5,0.9", "--robot", file, "--out", out, "--json", "--quiet"]
    person = subprocess.Popen([c.program, *map(str, words)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True)
    for torque in (None, 0.5, 0.9):
        if "Enter" not in person.stderr.readline():
            break
        if torque:
            press(torque)
        try:
            person.stdin.write("\n")
            person.stdin.flush()
        except BrokenPipeError:
            break
    printed, said = person.communicate(timeout=60)
    if not printed:
        return said or "nothing was said"
    c.validate("hal-hand", json.loads(printed), "colift hal hand calibrate")
    return ""


def camera(c, folder):
    address = f"@colift-schemas-{os.getpid()}"
    hal = lambda *words: c.command("hal-camera", "hal", "camera", *words, tries=TRIES)
    with Emulator(c, "camera", "--address", address) as kinect:
        info = hal("info", "--source", f"emulated:{address}", "--for", 0.5)
        openni2 = hal("info", "--source", f"openni2:emulated:{address}", "--for", 0.5)
        noise = hal("noise", "--source", f"emulated:{address}", "--for", 0.7)
        hal("tilt", 3, "--yes", "--source", f"emulated:{address}", "--for", 0.5)
        live = ended(c, kinect, "camera")
    hal("watch", "--source", f"emulated:{address}-nobody", "--for", 0.2)
    frames = folder / "fakenect"
    c.command("emulate", "emulate", "camera", "--fakenect", frames, "--for", 0.3)
    hal("watch", "--source", f"fakenect:{frames}", "--for", 5)
    intrinsics = {"fx": 600, "fy": 600, "cx": 320, "cy": 240, "width": 640, "height": 480, "depth_scale_m": 0.001}
    (folder / "camera.json").write_text(json.dumps(intrinsics))
    video = robot(folder, "video", camera="v4l2", v4l2={"device": str(folder / "none"), "intrinsics": str(folder / "camera.json")})
    hal("info", "--robot", video, "--for", 0.2)
    if noise and noise["end"] == "done" and "noise" not in noise:
        c.wrong.append("colift hal camera noise: a document without what was measured")
    if info:
        c.has_to_fail("hal-camera", info, lambda d: d.update(state="fine"), "a state that does not exist")
        c.has_to_fail("hal-camera", info, lambda d: d["depth_m"].pop(), "two depths")
        c.has_to_fail("hal-camera", info, lambda d: d["frames"].pop("missed"), "a Kinect that does not say what it missed")
    if openni2:
        c.has_to_fail("hal-camera", openni2, lambda d: d["dropped"].update(old=-1), "fewer than no old frames")
        c.has_to_fail("hal-camera", openni2, lambda d: d["process"].pop("pid"), "a process without a number")
    c.has_to_fail("emulate", live, lambda d: d.update(frames=3), "a live camera with frames as a number")
    wires = robot(folder, "rig", arm="fri", hand="barrett", camera="kinect", kinect={"source": f"emulated:{address}-rig"},
                  fri={"address": "127.0.0.1", "krc": "127.0.0.1", "port": free_port(socket.SOCK_DGRAM)},
                  barrett={"can": f"socketcand:127.0.0.1:{free_port(socket.SOCK_STREAM)}/can0"})
    rig = c.command("emulate", "emulate", "rig", "--robot", wires, "--for", 1, tries=TRIES)
    if rig:
        c.has_to_fail("emulate", rig, lambda d: d["arm"].pop("script"), "a rig whose arm has no program")


def recovery(c):
    """After a stop: of a rig at home, and of a run that is stopped at the object."""
    recovered = c.command("recover", "recover", "--yes")
    if recovered:
        c.has_to_fail("recover", recovered, lambda d: d.update(outcome="saved"), "an outcome that does not exist")
        c.has_to_fail("recover", recovered, lambda d: d["before"].pop("load_n"), "a recovery that does not know of a load")
    run = subprocess.Popen([c.program, "run", "--seed", "1", "--recover", "--json"], stdin=subprocess.DEVNULL,
                           stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for line in run.stderr:
        if " s  close " in line:
            run.send_signal(signal.SIGINT)
            break
    document = json.loads(run.communicate(timeout=300)[0])
    c.validate("run", document, "colift run --recover")
    told = document.get("recovery") or {}
    if not told.pop("truth", None) or len(told.get("steps", [])) < 2:
        c.wrong.append("colift run --recover: a run that was stopped at the object tells of no steps back home")
    c.validate("recover", told, "recovery of colift run --recover")
