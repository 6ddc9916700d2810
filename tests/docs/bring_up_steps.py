"""What walk_bring_up.py expects of each command of docs/bring-up.md: exit code, words that it prints, what a person does meanwhile.

STEPS: by section, then by the text that stands in the document; a list of runs, or the reason why there is none.
FAR_ENDS: the emulators, by section. Their addresses, and the robot file rig.yaml that names them, come from the walk.
"""

import dataclasses


@dataclasses.dataclass
class Run:
    """One command that is carried out. Without `command`: the document's own text."""
    command: str = ""
    at: str = ""  # the emulator; without: the section's first; "none": no device
    after: str = ""  # what the emulator has to have said before
    code: tuple = (0,)
    says: tuple = ()  # patterns, each of which has to occur in what it prints
    sees: tuple = ()  # the same, of what the emulator prints from then on
    person: tuple = ()  # what a person does meanwhile: the functions below
    terminal: bool = False
    robot: dict = dataclasses.field(default_factory=dict)  # lines of rig.yaml from here on, None: none
    files: tuple = ()  # have to be there afterwards
    starts: bool = False  # the emulator itself is what the document shows
    only: str = ""  # "long", "short"
    here: str = ""  # why it is not as in the document, or what takes a person's place


# What a person does: (what, a pattern or a text).
def reads(pattern):
    return "reads", pattern


def sees(pattern):  # what the emulator says: the person has done something
    return "sees", pattern


def not_yet(pattern):  # else this machine was too slow for the emulator's times: begin anew
    return "not yet", pattern


ENTER = ("types", "\n")
CTRL_C = ("interrupts", "")
HOLDS_SPACE = ("holds space", "")

CAMERA_AT = "2.0,-1.5,1.5"  # half a hand beside the truth, as a person would measure it
CLEARED_FLOOR = """schema: colift.scenario/1
object: {kind: box, size: [0.3, 0.3, 0.3], mass: 2.0, pose: {xyz: [-1.6, 1.6, 0.0]}}
camera: {xyz: [2.1, -1.4, 1.5], look_at: [1.15, 0.0, 0.3], noise: kinect}
partner: {kind: none}
"""
INIT = ("colift hal hand init",)
WEIGHTS = "".join(f" --fault {at}:weight={nm}@{finger}:3" for finger, first in (("F1", 8), ("F2", 22))
                  for at, nm in zip(range(first, first + 12, 3), ("0.2", "0.4", "0.6", "0")))

FAR_ENDS = {  # words behind "colift emulate", and commands that prepare the device
    "arm": {
        "krc": ("krc", ()),
        "pushed": ("krc --fault 0:contact=30:3600", ()),
        "stop": ("krc --fault 8:estop:600", ()),
        "heavier": ("krc --fault 0:load=0.2:1e9", ()),
    },
    "hand": {
        "empty": ("hand --plant light", ()),
        "pushed": ("hand --plant light --fault 8:weight=0.3@F2:600", INIT),
        "warm": ("hand --plant light --width 0.10 --fault 8:hot=50:3600", INIT),
        "ball": ("hand --plant light --width 0.10", INIT),
        "pulled": ("hand --plant light --width 0.10 --fault 8:weight=-0.3@F1:3 --fault 8:weight=-0.3@F2:3", INIT),
        "gauges": ("hand --plant light --width 0.10 --gauges 1,1.3,0.8" + WEIGHTS, INIT),
    },
    "camera": {
        "camera": ("camera --scenario cleared.yaml", ()),
        "unplugged": ("camera --scenario cleared.yaml --fault 4:unplug:3", ()),
        "rig": ("rig --scenario cleared.yaml --robot rig.yaml", ()),
    },
    "run": {
        "dry": ("rig --scenario table --robot rig.yaml", ()),
        "t1": ("rig --scenario table --robot rig.yaml", ()),
        "t1 whole": ("rig --scenario table --robot rig.yaml", ()),
    },
    "emulated": {"rig": ("rig --scenario table --robot emulated.yaml", ())},
}

MOVED = r"A{0} moved by {1}5\.0\d deg \(asked for {1}5\.00\)"
ONE_FINGER = (r"its gauge measured up to", r"its motor rests, as read back")
OPENED = (r"to 0, 0, 0 deg", r"motors at rest, as read back: F1, F2, F3")


def other_joints():
    return [Run(f"colift hal arm move-joint {n} {deg} --speed 13", says=(MOVED.format(n, r"\+" if deg > 0 else "-"),), only="" if n in (1, 4) else "long",
                here="other joints too, by +5 and -5, a little faster") for n in range(1, 7) for deg in (5, -5)]


def weighed(finger, first, more=()):
    """The person at the hand: hangs a weight when told, and presses Enter while it hangs."""
    steps = [reads(f"nothing touches {finger}"), ENTER]
    for i, nm in enumerate(("0.2", "0.4", "0.6")):
        steps += [reads(f"bend {finger} open with {nm}0 N m"), not_yet(rf"fault begins: {first + 3 * i}:"),
                  sees(rf"fault begins: {first + 3 * i}:weight={nm}@{finger}"), ENTER]
    return (*steps, *more)


STEPS = {
    "arm": {
        "colift hal arm limits": [Run(at="none", says=(r"limits +guarded", r"in T1", r"^A7 +A6 "), here="touches no device")],
        "colift hal arm state": [Run(says=(
            r"monitor mode, quality (ok|perfect)", r"answer rate \d\.\d+", r"power 0x7F \(all on\), errors none",
            r"^A3 +E1 ", r"^A7 +A6 .* on$", r"KRL program +colift\.src waits"))],
        "colift hal arm watch --for 600": [Run("colift hal arm watch --for 3", here="3 s instead of ten minutes", says=(
            r"monitor, quality", r" 0 lost", r"from datagram to answer", r"up to +\d+ us +\d+ +#+$"))],
        "watch": [Run("colift hal arm watch --for 3", "pushed", here="a push of 30 N down at the flange", says=(
            r"force \(-?0\.\d, -?0\.\d, -(29|30)\.\d\) N",))],
        "colift hal arm hold --control position --for 5": [Run(sees=(r"command mode: friStart", r"command mode left: the client asked for a stop"), says=(
            r"asks for command mode", r"held the measured pose for 5\.0 s", r"it ended 0\.0\d\d deg from its start"))],
        "colift hal arm move-joint 7 5 --control position": [Run(says=(MOVED.format(7, r"\+"), r"leaves command mode")), *other_joints()],
        "colift hal arm load --yes": [
            Run(says=(r"measured the load in 10 of 10 poses", r"the load is \+0\.00 kg")),
            Run(at="heavier", only="long", code=(1,), here="the tool weighs 0.2 kg more than the load data", says=(
                r"the load is \+0\.(19|20|21) kg", r"the KRC's load data are wrong.* enter 1\.1[789] kg"))],
        "colift hal arm stiffness 300 --for 30": [Run("colift hal arm stiffness 300 --for 3", here="3 s, and nobody pushes", says=(
            r"for 3\.0 s with 300 N m/rad; it ended 0\.0\d\d deg",))],
        "hold": [Run("colift hal arm hold --for 60", "stop", code=(3,), here="an emergency stop 8 s after the controller's start",
                     person=(not_yet("fault begins"), reads(r"commands, measured"), not_yet("fault begins"), sees("brakes closed")),
                     says=(r"the drives are off \(power 0x00",)),
                 Run("colift hal arm state", "stop", says=(
                     r"monitor mode", r"power 0x00 \(all off\)", r"would be refused now", r"the KRL program is stopped", r"emergency stop"),
                     here="nothing starts again by itself")],
        "colift hal arm switch joint_impedance position cartesian_impedance --for 2": [
            Run("colift hal arm switch joint_impedance position cartesian_impedance --for 1", here="1 s in each", says=(
                r"^joint_impedance: command mode after", r"^position: command mode after",
                r"^cartesian_impedance: command mode after .*joints within 0\.0\d\d deg"))],
        "colift hal arm doctor --out FILE.tar": [Run("colift hal arm doctor --out arm.tar", files=("arm.tar",), says=(r"arm\.tar: state, answer times",))],
    },
    "hand": {
        "colift hal hand state": [Run(says=(r"4 of 4 pucks answer", r"status +asleep +asleep +asleep +asleep", r"firmware +200"))],
        "colift hal hand init": [
            Run(says=(r"the fingers open to their stops", r"inner +deg +0\.0 +0\.0 +0\.0 +0\.0"), sees=(r"spread has found its stop",)),
            Run("colift hal hand state", says=(r"zero +known +known +known +known", r"supply +V +48"), here="the hand is awake now")],
        "colift hal hand watch": [
            Run(at="pushed", here="a push of 0.3 N m at F2, then Ctrl-C",
                person=(reads(r"strain 0\.00 0\.00 0\.00"), not_yet("fault"), sees(r"fault begins: 8:weight"), reads(r"strain -?0\.00 0\.(29|30|31)"), CTRL_C)),
            Run("colift hal hand watch --for 3", "warm", after="fault begins: 8:hot", says=(r"warning +the hand has \d\d C: its pucks give \d\d %",),
                here="a hand of 50 deg C")],
        "colift hal hand tactile": [
            Run("colift hal hand finger F1 70", "ball", code=(1,), says=(r"F1 .*it was stopped by what it met",), here="F1 alone presses on the ball"),
            Run(at="ball", person=(reads(r"pads \d\.\d 0\.0 0\.0 N"), CTRL_C), here="ended by Ctrl-C",
                says=(r"^F1 +\d\.\d N +#+$", r"^F2 +0\.0 N *$", r"^F3 +0\.0 N *$")),
            Run("colift hal hand open --yes", "ball", says=OPENED, here="F1 back")],
        "colift hal hand preshape 90": [Run(says=(r"spread from 0 to 90 deg",))],
        "0": [Run("colift hal hand preshape 0", says=(r"spread from 90 to 0 deg",))],
        "colift hal hand close --torque 0.3": [Run(code=(1,), says=(r"to 137, 137, 137 deg", r"it holds nothing", r"the fingers closed on nothing"))],
        "colift hal hand open --yes": [
            Run("colift hal hand open", code=(2,), says=(r"the hand may hold something.*--yes",), here="not without --yes"),
            Run(says=OPENED)],
        "colift hal hand finger F1 40": [Run(says=(r"F1 from 0\.0 to (39|40)\.\d deg .*it has arrived", *ONE_FINGER))],
        "step F1 -10": [Run("colift hal hand step F1 -10", says=(r"F1 from .* to (29|30)\.\d deg", *ONE_FINGER))],
        "velocity F1 20 --for 1": [Run("colift hal hand velocity F1 20 --for 1", says=(r"in 1\.\d s: its time is over", *ONE_FINGER))],
        "torque F1 0.2 --yes": [Run("colift hal hand torque F1 0.2 --yes", says=(r"F1 from .*: it", *ONE_FINGER))],
        "preshape 0 --fingers 40 --yes": [Run("colift hal hand preshape 0 --fingers 40 --yes", says=(
            r"F1 from 0\.0 to (39|40)\.\d deg", r"F2 from 0\.0 to (39|40)\.\d deg", r"F3 from 0\.0 to (39|40)\.\d deg"))],
        "colift hal hand grip --torque 0.5 --for 10": [
            Run("colift hal hand grip --torque 0.5 --for 2 --bus-log hand.log", "ball", files=("hand.log",), here="2 s, logged for the replay below", says=(
                r"holds something", r"it holds something; strain 0\.", r"motors at rest, as read back: F1, F2, F3", r"the worm gears hold")),
            Run("colift hal hand open", "ball", code=(2,), says=(r"the hand may hold something.*--yes",), here="not without --yes while it holds something"),
            Run("colift hal hand grip --torque 0.5 --for 60", "pulled", code=(1,), here="somebody pulls at the ball, and it comes free",
                person=(reads("holds something"), not_yet("fault"), sees("fault begins: 8:weight")), says=(r"the grip slipped after",)),
            Run("colift hal hand grip --torque 0.5 --for 2", "warm", code=(1,), says=(r"it holds nothing", r"its puck gives \d\d % of its torque"),
                here="a hand of 50 deg C gives too little")],
        "colift hal hand open --yes #2": [Run("colift hal hand open --yes", "ball", says=OPENED)],
        "colift hal hand calibrate F1 --torques 0.2,0.4,0.6 --out hand.yaml": [
            Run(at="gauges", person=weighed("F1", 8), files=("hand.yaml",), here="the weights hang on the emulated finger; Enter after each",
                says=(r"0\.60 N m applied", r"true torque = (0\.9[89]|1\.0[012])\d* of the curve's"))],
        "--press --yes": [
            Run("colift hal hand calibrate F2 --torques 0.2,0.4,0.6 --out hand.yaml --press --yes", "gauges", here="F2, the ball is what it presses on",
                person=weighed("F2", 22, (reads("something rigid"), not_yet("fault begins: 31:"), sees("fault begins: 31:weight=0@F2"), ENTER)),
                says=(r"true torque = 1\.(2[89]|3[012])\d* of the curve's", r"\d{4} units of the motor for 1 N m")),
            Run("colift hal hand open --yes", "gauges", says=OPENED),
            Run("colift hal hand watch --for 1", "gauges", robot={"calibration_file": "hand.yaml"}, says=(r"start +F3 \(puck 113\) is not in hand\.yaml",),
                here="barrett: {calibration_file: hand.yaml} in rig.yaml from here on")],
        "colift emulate hand --gauges 1,1.3,0.8": [Run(at="gauges", starts=True, here="the far end of step 10")],
        "colift hal hand replay hand.log": [Run(at="none", says=(r"driver +says what was recorded", r"emulator +answers in the form of the recording"))],
        "colift hal hand emergency-open --yes": [Run(at="gauges", says=(r"^F1 opened by", r"^F2 opened by", r"^F3 opened by .*its motor rests"))],
    },
    "camera": {
        "colift hal camera info": [Run(says=(
            r"serial \S+, streaming", r"at [23]\d\.\d Hz", r"(8[5-9]|9\d)\.\d % of the pixels", r"looks 35\.\d deg down, leans 0\.\d deg"))],
        "colift hal camera watch --png frame.png": [Run(files=("frame.png",), says=(r"picture: frame\.png",), here="nobody looks at the picture")],
        "colift hal camera noise --out noise.yaml": [Run(files=("noise.yaml",), says=(r"noise at 1 m 1\.\d mm .* at 2 m [45]\.\d mm", r"noise model: noise\.yaml"))],
        "colift hal camera watch": [Run("colift hal camera watch --for 3", says=(r" 0 suspect .* 0 old",), here="3 s instead of minutes")],
        "pull the USB cable, plug it in again": [
            Run("colift hal camera watch", "unplugged", here="the emulated cable, for 3 s; then Ctrl-C",
                person=(reads(r"Hz, \d+ frames"), not_yet("unplug:3 begins"), sees("4:unplug:3 begins"), reads("lost"), reads("again"), CTRL_C))],
        "colift hal camera record folder --for 5": [
            Run("colift hal camera record folder --for 1", files=("folder/INDEX.txt",), says=(r"recorded +\d+ frames, .* in folder",), here="1 s"),
            Run("colift hal camera watch --source fakenect:folder", "none", says=(r"lost: the recording is over", r"fakenect:folder"), here="the recording plays")],
        "record --scene folder": "somebody has to put an object down and lift it",
        "a tape measure at 1 m and 2 m": "needs a tape measure; the emulated Kinect measures a simulated world",
        "colift hal camera info --infrared ir.png": [Run(files=("ir.png",), says=(r"infrared image: ir\.png",), here="nobody looks at the picture")],
        "colift calibrate --robot rig.yaml --camera-at X,Y,Z --save samples --out camera.yaml": [
            Run(f"colift calibrate --sim --scenario cleared.yaml --poses 12 --camera-at {CAMERA_AT} --save samples --out camera.yaml", "none", only="short",
                files=("camera.yaml", "samples/samples.yaml"), says=(r"poses +\d+ of 12 agree", r"written: camera\.yaml", r"truth +[0-4]\.\d mm off"),
                here="in simulated time, 12 poses: over the wires (--long) it takes minutes"),
            Run(f"colift calibrate --robot rig.yaml --camera-at {CAMERA_AT} --save samples --out camera.yaml", "rig", only="long",
                files=("camera.yaml", "samples/samples.yaml"), says=(r"written: camera\.yaml", r"error +[0-4]\.\d mm predicted"))],
        "calibration: camera.yaml": "a line of rig.yaml: it stands there from the next command on",
        "colift hal camera info --robot rig.yaml --depth frame.png": [
            Run(robot={"calibration": "camera.yaml"}, files=("frame.png", "camera.json"), says=(r"depth image: frame\.png",))],
        "colift check --robot rig.yaml --frame frame.png": [Run(at="none", says=(
            r"calibration camera\.yaml: of today .*residual 0\.\d+ px", r"the ground is level within 0\.\d deg and \d+ mm (below|above) the robot's floor"))],
        "colift emulate camera": [Run(starts=True, here="the far end of these steps")],
        "colift hal camera tilt DEG --yes": [
            Run("colift hal camera tilt 3", code=(2,), says=(r"it moves the camera.*--yes",), here="not without --yes"),
            Run("colift hal camera tilt 3 --yes", says=(r"mounting +looks",))],
    },
    "run": {
        "colift doctor --robot rig.yaml": [Run(at="none", code=(0, 3), says=(r"\d+ of \d+ fine, \d+ to look at, \d+ bad", r"UDP port \d+ +free", r"capture process +colift-kinect"),
                                               here="exit code 3 where this machine is not fit for a robot")],
        "colift calibrate --robot rig.yaml --camera-at X,Y,Z --out camera.yaml": [
            Run("colift run --robot rig.yaml --dry-run", "none", robot={"calibration": None}, code=(2,), says=(r"no camera pose is configured",),
                here="without a calibration a run is refused"),
            Run("colift calibrate --samples samples --out camera.yaml", "none", robot={"calibration": "camera.yaml"}, files=("camera.yaml",),
                says=(r"written: camera\.yaml", r"error +[0-4]\.\d mm predicted"), here="from the images of the Kinect's step 8")],
        "colift run --robot rig.yaml --dry-run --png seen.png": [
            Run(at="dry", files=("seen.png",), says=(r"a reachable grasp is chosen", r"dry run: a collision-free path was found, nothing"))],
        "colift run --robot rig.yaml --set arm_mode=t1 --record first.mcap": [
            Run(at="t1 whole", only="long", files=("first.mcap",), says=(r"lifted +held 5\.0 cm for 2 s",)),
            Run(at="t1", code=(130,), files=("first.mcap",), person=(reads(r" s  hold "), CTRL_C), here="Ctrl-C while both hold the table: the stop for what follows",
                says=(r"the partner grasps the object", r"the arm holds and the grip stays closed", r"the hand still holds the object"))],
    },
    "stop": {
        "colift recover --robot rig.yaml": [Run(at="t1", terminal=True, person=(HOLDS_SPACE,), here="the walk holds the space bar of a terminal", says=(
            r"arm: +at rest, away from home", r"hand: .*it may hold an object", r"load: \d+ N at the palm", r"lowers the hand straight down",
            r"the object is supported", r"opens the hand", r"draws the open hand straight back", r"moves home, around what the camera observes",
            r"recovered: the arm is at home"))],
        "colift run --recover": "in simulation; the test docs_schemas carries it out",
    },
    "emulated": {
        "colift emulate rig --scenario table": [Run(starts=True)],
        "colift run --robot emulated": [
            Run("colift run --robot emulated.yaml --json", says=(r'"schema":"colift\.run/1","outcome":"lifted"', r" s  done +lifted, set down, released"),
                sees=(r"the scenario begins",), here="config/emulated.yaml with other ports"),
            Run("colift recover --robot emulated.yaml --yes", says=(r"recovered: the hand is open and the arm is at home",), here="nothing is left to do")],
    },
}

CABLING = {  # of the lines for a shell in the sections about cabling; the reason why they are not carried out
    r"sudo ip (addr|link) ": "the network card of the KRC, the CAN interface of the hand: a real machine's",
    r"sudo modprobe vcan": "a kernel module; `tests/can_vm` has it in a virtual machine",
}
