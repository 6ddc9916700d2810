"""Files that the program reads: what is shipped is valid, and a schema accepts and refuses what the program does."""

import copy
import json
import subprocess

from schema_checker import read_yaml


class Files:
    """A schema of files beside the program that reads them."""

    def __init__(self, c, folder, name, words):
        self.c, self.name, self.words, self.file = c, name, words, folder / f"checked_{name}.yaml"

    def refusal(self, document):
        """What the program says against it; empty: it goes on to what comes next, which is not there."""
        self.file.write_text(json.dumps(document))
        said = self.c.run(*self.words(self.file)).stderr
        return said if f"{self.file}:" in said else ""

    def good(self, document, what):
        self.c.validate(self.name, document, what)
        if said := self.refusal(document):
            self.c.wrong.append(f"the schema {self.name} accepts {what}, the program does not: {said[-300:]}")

    def bad(self, document, change, what):
        broken = self.c.has_to_fail(self.name, document, change, what)
        if not self.refusal(broken):
            self.c.wrong.append(f"the program accepts {what}, the schema {self.name} does not")


def shape(schema, root, side):
    """A document with every key of a schema of plain entries: lowest values and first words, or highest and last."""
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rsplit("/", 1)[1]]
    if "anyOf" in schema:
        return shape(schema["anyOf"][0], root, side)
    if "properties" in schema:
        return {k: shape(v, root, side) for k, v in schema["properties"].items() if not v.get("deprecated")}
    if "enum" in schema:
        return schema["enum"][side]
    kind = schema["type"]
    if kind in ("number", "integer"):
        return schema.get("minimum", 0.001) if side == 0 else schema.get("maximum", 1e6)
    return {"boolean": bool(side), "string": "text"}[kind] if kind != "array" else [shape(schema["items"], root, side)]


def limits(schema, root, way=()):
    """Every number with a limit: the keys that lead to it, and a value beyond."""
    if "$ref" in schema:
        schema = root["$defs"][schema["$ref"].rsplit("/", 1)[1]]
    for k, v in schema.get("properties", {}).items():
        if "maximum" in v:
            yield (*way, k), v["maximum"] + 1
        elif "minimum" in v or "exclusiveMinimum" in v:
            yield (*way, k), v.get("minimum", 0) - 1
        elif "$ref" in v:
            yield from limits(v, root, (*way, k))


def put(value, *way):
    """Changes an entry of a document."""
    def change(document):
        for key in way[:-1]:
            document = document[key]
        document[way[-1]] = value
    return change


def robots(c, folder, root):
    robot = Files(c, folder, "robot", lambda file: ("check", "--robot", file))
    for file in sorted((root / "config").glob("*.yaml")):
        robot.good(read_yaml(file), file.name)
    schema = c.schema("robot")
    for side, what in ((0, "every key at its lowest"), (-1, "every key at its highest")):
        robot.good({**shape(schema, schema, side), "calibration": ""}, what)
    real = read_yaml(root / "config/real.yaml")
    robot.good({**real, "camera": {"driver": "ros2", "image": "/depth", "info": "/info"}}, "a camera in one group")
    robot.bad(real, put({"driver": "ros3"}, "camera"), "a driver that does not exist")
    robot.bad(real, put("fri", "hand"), "a hand over FRI")
    robot.bad(real, put(1, "fri", "adress"), "a misspelled key")
    robot.bad(real, put("yes", "kinect", "motor"), "a motor in words")
    robot.bad(real, put(1.5, "fri", "port"), "half a port")
    for way, value in limits(schema, schema):
        change = {way[-1]: value} if len(way) == 1 else {way[0]: {way[1]: value}}
        robot.bad({}, lambda d, change=change: d.update(change), f"{'.'.join(way)}: {value}")


def hand_calibrations(c, folder, measured):
    def words(file):
        named = folder / "checked_hand.yaml"
        named.write_text(json.dumps({"hand": "barrett", "barrett": {"can": "socketcand:127.0.0.1:1/can0", "calibration_file": str(file)}}))
        return "hal", "hand", "state", "--robot", named
    scales = Files(c, folder, "hand-calibration", words)
    if not measured.exists():
        return  # that it was not measured has been said
    document = read_yaml(measured)
    scales.good(document, "the file of colift hal hand calibrate")
    scales.bad(document, put(0, "pucks", 0, "serial"), "a puck without serial number")
    scales.bad(document, put(9, "pucks", 0, "strain_scale"), "a scale of 9")
    scales.bad(document, put(1, "pucks", 0, "scale"), "a key that does not exist")
    scales.bad(document, lambda d: d.pop("schema"), "a file without schema")


def rigs(c, folder, root):
    rig = Files(c, folder, "rig", lambda file: ("run", "--rig", file, "--quiet"))
    shipped = read_yaml(root / "config/rig/imperfect.yaml")
    c.validate("rig", shipped, "imperfect.yaml")
    run = subprocess.Popen([c.program, "run", "--rig", root / "config/rig/imperfect.yaml"], stdout=subprocess.DEVNULL,
                           stderr=subprocess.PIPE, text=True)
    if "observe" not in (said := run.stderr.readline()):
        c.wrong.append(f"the program does not begin with the shipped rig: {said}")
    run.kill()
    run.communicate()
    rig.bad(shipped, put("mm", "camera", "position", "unit"), "a position in millimetres")
    rig.bad(shipped, put(" ", "arm", "tool_mass", "source"), "a figure without source")
    rig.bad(shipped, put(-0.1, "hand", "strain_drift", "value"), "a bound below 0")
    rig.bad(shipped, put({}, "arm", "tool_mas"), "a misspelled key")
    rig.bad(shipped, lambda d: d["world"].pop("partner_max"), "a rig without a latest partner")


WHOLE = {
    "schema": "colift.scenario/1",
    "object": {"kind": "bodies", "mass": None, "cog_offset": [0, 0, 0.01], "pose": {"xyz": [1.1, 0, 0], "yaw_deg": -360}, "friction": 3,
               "parts": [{"shape": "box", "size": [0.8, 0.6, 0.4], "xyz": [0, 0, 0.2], "rpy_deg": [0, 0, 90], "mass": 3},
                         {"shape": "cylinder", "size": [0.05, 0.3], "xyz": [0, 0, 0.5], "mass": 1}]},
    "clutter": [{"shape": "box", "size": [0.1, 0.2, 5], "xyz": [-20, 20, 0], "yaw_deg": 360, "moves": [{"at_s": 36000, "to": [0, 2, 0]}]},
                {"shape": "cylinder", "size": [0.001, 0.4], "xyz": [0, 2, 0], "moves": [{"at_s": 0, "to": [0, 2, 0], "speed": 3}]}],
    "camera": {"xyz": [2.1, -1.4, 1.5], "look_at": [1.15, 0, 0.3], "noise": "none"},
    "more_cameras": [{"xyz": [2, 1, 1], "look_at": [1, 0, 0.3]}],
    "partner": {"kind": "leader", "grasp": [0.4, 0, 0.4], "arrives_s": 0, "obliging": True, "events": [
        {"at_s": 5, "do": "let-go"}, {"at": "lift+0.7", "do": "move", "to": [0.4, 0, 0.4]},
        {"at": "test-lift", "do": "second-hand", "to": [0, 0, 0]},
        {"at": "hold+1e1", "do": "stumble", "force": 500, "for_s": 0, "direction": [0, 0, -1]},
        {"at_s": 9, "do": "sway", "by": 0.2, "for_s": 1}, {"at_s": 9, "do": "steps-aside"}, {"at_s": 9, "do": "confirm-lower"},
        {"at_s": 9, "do": "confirm-continue"}]},
    "task": {"kind": "lift", "height": 0.5, "hold_s": 0},
    "people": [{"path": [[0, 3]]}, {"enters_s": 1, "path": [[0, 3], [1, 1]], "speed": 0.01, "do": "reach", "reach_to": [1, 0, 0.5],
                                    "with": "foot", "hand_speed": 3, "leaves_s": 9},
               {"enters": "approach+0.5", "path": [[0, 3]], "do": "reach", "reach_to": "point", "point": [1, 0, 0.5]},
               {"path": [[0, 3]], "do": "reach", "reach_to": "between-fingers"}],
    "faults": [{"at_s": 4, "device": "camera", "do": "blind", "for_s": 0.25}, {"at": "lift", "device": "camera2", "do": "holes"},
               {"at_s": 4, "device": "hand", "do": "hot", "value": 70, "puck": "F2"}, {"at_s": 4, "device": "arm", "do": "emergency-stop"},
               {"at_s": 4, "device": "arm", "do": "push", "value": 20, "direction": [0, 1, 0], "link": 7}]}
TABLE = {"schema": "colift.scenario/1", "object": {"kind": "table", "size": [0.8, 0.6, 0.45]}, "partner": {"grasp": [0.4, 0, 0.44]}}


def scenarios(c, folder, root):
    scenario = Files(c, folder, "scenario", lambda file: ("run", "--scenario", file, "--robot", folder / "none.yaml", "--quiet"))
    for file in sorted((root / "config/scenario").glob("*.yaml")):
        c.validate("scenario", read_yaml(file), file.name)
    scenario.good(WHOLE, "a scenario with every key")
    scenario.good(TABLE, "a table")
    for way in ("schema", "object", "partner"):
        scenario.bad(TABLE, lambda d, way=way: d.pop(way), f"a scenario without {way}")
    for kind, size in (("box", [1, 1]), ("cylinder", [1, 1, 1]), ("table", [0.8, 0.1, 0.45]), ("chair", [0.4, 0.4, 0.3]),
                       ("bodies", [1, 1, 1]), ("anvil", [1, 1, 1])):
        scenario.bad(TABLE, lambda d, kind=kind, size=size: d["object"].update(kind=kind, size=size), f"a {kind} of {size}")
    for value, *way in (
            (1, "objekt"), (4, "object", "weight"), (0, "object", "mass"), (0, "object", "friction"), (361, "object", "pose", "yaw_deg"),
            ([0.1, 0.1], "object", "parts", 0, "size"), (None, "object", "parts", 1, "mass"), ([], "object", "parts"),
            ("cone", "clutter", 0, "shape"), ([0.1, 0.2], "clutter", 0, "size"), ([0, 21, 0], "clutter", 0, "xyz"),
            (4, "clutter", 1, "moves", 0, "speed"), ("some", "camera", "noise"), ("none", "partner", "kind"), ("lazy", "partner", "kind"),
            (-1, "partner", "arrives_s"),
            ([0, 0, 0], "partner", "events", 0, "to"), (4, "partner", "events", 0, "force"), (0.3, "partner", "events", 4, "by"),
            ("lift+0.7", "partner", "events", 0, "at"), ("lifting", "partner", "events", 1, "at"), ("lift+", "partner", "events", 1, "at"),
            ({"at_s": 1, "do": "move"}, "partner", "events", 0), ({"do": "let-go"}, "partner", "events", 0), (0.6, "task", "height"),
            ([[0, 3, 1]], "people", 0, "path"), ([], "people", 0, "path"), ("object", "people", 0, "reach_to"),
            ("hand", "people", 0, "with"), ([0, 0, 0], "people", 3, "point"), ("lift", "people", 1, "enters"),
            ({"path": [[0, 3]], "do": "reach"}, "people", 0),
            ("hot", "faults", 0, "do"), ("blind", "faults", 3, "do"), ("F4", "faults", 2, "puck"), ("F2", "faults", 0, "puck"),
            (0, "faults", 4, "value"), (8, "faults", 4, "link"), ("foot", "faults", 0, "device"), ("melt", "faults", 0, "do"),
            ([TABLE["object"]] * 11, "people")):
        scenario.bad(WHOLE, put(copy.deepcopy(value), *way), f"a scenario with {'.'.join(map(str, way))}: {json.dumps(value)[:60]}")
