#!/usr/bin/env python3
"""Holds the tree to its documented direction: who may include whom.

    check_includes.py [--root DIR] [--print]

`rooms.txt` beside this file names every room (a folder; its sub-folders belong to it unless they have a line of their own) and
what it may include. Refused are

- an include that the table does not allow, or of a file that does not exist;
- a table that allows a cycle between rooms;
- a header of a heavy library outside the files that may see it;
- a room without a line, a line without a room, and a permission that nobody uses any more;
- a source file of more than 440 lines, and a folder of more than 24 source files.

--print writes the arrows as they are, in the format of the table. Ends with 1 when something is refused.
"""
import argparse, collections, pathlib, re, sys

HERE = pathlib.Path(__file__).resolve().parent
TOP = ("hal", "perception", "planner", "control", "sim_hal", "tools")
INCLUDE = re.compile(r'^\s*#\s*include\s+(?:"([^"]+)"|<([^>]+)>)')
MAX_LINES, MAX_FILES = 440, 24

# heavy or platform libraries, and the places that may see them (a prefix of the path)
LIBRARIES = {
    r"pcl/": ("perception/thesis/",),
    r"octomap/|dynamicEDT3D/": ("perception/map/", "planner/motion/collision/exact_checker.cpp"),
    r"fcl/": ("planner/motion/collision/exact_checker.cpp",),
    r"ompl/": ("planner/motion/rrt_connect.cpp",),
    r"mujoco/": ("sim_hal/mujoco/engine/",),
    r"urdf_(model|parser|world)|tinyxml": ("hal/robot_model/",),
    r"yaml-cpp/": ("hal/config/yaml_tree.cpp",),
    r"cairo": ("tools/visualization/canvas.cpp",),
    r"CLI/": ("tools/programs/",),
    r"boost/(beast|asio)": ("tools/live/",),
    r"nlohmann/json\.hpp": ("hal/drivers/recorded/camera_file.cpp", "tools/"),
    r"liblzf/": ("hal/drivers/recorded/cloud_files/pcd.cpp",),
    r"png\.h": ("hal/drivers/recorded/", "perception/calibration/grey_png.cpp", "tools/telemetry/replay/"),
    r"zstd\.h": ("tools/telemetry/mcap/",),
    r"zlib\.h": ("tools/telemetry/mcap/", "tools/visualization/animated_png.cpp"),
    r"dds/dds(\.h|rt/)|(ros2|colift)_messages\.h": ("hal/dds/", "hal/drivers/ros2_camera/", "sim_hal/emulator/ros2/", "tools/dds/"),
    r"OniCAPI|OpenNI\.h|Driver/Oni": ("hal/drivers/openni2_camera/capture/", "sim_hal/emulator/camera/openni2/"),
    r"libfreenect": ("hal/drivers/kinect/capture/", "sim_hal/emulator/camera/freenect/"),
}


def read_rooms(path):
    rooms = {}
    for number, line in enumerate(path.read_text().splitlines(), 1):
        line = line.split("#")[0].strip()
        if not line:
            continue
        if ":" not in line:
            sys.exit(f"{path}:{number}: expected 'room: rooms that it may include', found '{line}'")
        room, allowed = line.split(":", 1)
        rooms[room.strip()] = set(allowed.split())
    return rooms


def room_of(path, rooms):
    folder = path.rsplit("/", 1)[0]
    while folder not in rooms:
        if "/" not in folder:
            return None
        folder = folder.rsplit("/", 1)[0]
    return folder


def cycle_in(rooms):
    state, stack = {}, []

    def visit(room):
        state[room] = 1
        stack.append(room)
        for other in sorted(rooms.get(room, ())):
            if state.get(other) == 1:
                return stack[stack.index(other):] + [other]
            if other not in state:
                found = visit(other)
                if found:
                    return found
        state[room] = 2
        stack.pop()
        return None

    for room in sorted(rooms):
        if room not in state:
            found = visit(room)
            if found:
                return found
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--root", type=pathlib.Path, default=HERE.parents[1])
    parser.add_argument("--rooms", type=pathlib.Path, default=HERE / "rooms.txt")
    parser.add_argument("--print", action="store_true", dest="show")
    a = parser.parse_args()
    rooms = read_rooms(a.rooms)
    refused, used, sizes = [], collections.defaultdict(set), collections.Counter()
    files = sorted(p for top in TOP for p in (a.root / top).rglob("*.?pp")
                   if p.suffix in (".cpp", ".hpp") and "tools/cmake/" not in p.as_posix())
    for file in files:
        name = file.relative_to(a.root).as_posix()
        sizes[name.rsplit("/", 1)[0]] += 1
        room = room_of(name, rooms)
        if room is None:
            refused.append(f"{name}: its folder has no line in {a.rooms.name}")
            continue
        lines = file.read_text().splitlines()
        if len(lines) > MAX_LINES:
            refused.append(f"{name}: {len(lines)} lines (limit {MAX_LINES}): split it, one idea a file")
        for number, line in enumerate(lines, 1):
            match = INCLUDE.match(line)
            if not match:
                continue
            ours, system = match.groups()
            for library, places in LIBRARIES.items():
                if re.match(library, ours or system) and not name.startswith(places):
                    refused.append(f"{name}:{number}: <{ours or system}> belongs in {' or '.join(places)} only")
            if not ours or ours.split("/")[0] not in TOP or "/" not in ours:
                continue
            if not (a.root / ours).exists() and not ours.endswith(".inc"):
                refused.append(f"{name}:{number}: there is no {ours}")
                continue
            other = room_of(ours, rooms)
            if other is None or other == room:
                continue
            used[room].add(other)
            if other not in rooms[room]:
                refused.append(f"{name}:{number}: {room} may not include {other} ({ours})")
    if a.show:
        for room in rooms:
            print(f"{room}: {' '.join(sorted(used[room]))}")
        return 0
    for folder, count in sizes.items():
        if count > MAX_FILES:
            refused.append(f"{folder}: {count} source files (limit {MAX_FILES}): it wants rooms")
    for room, allowed in rooms.items():
        if not (a.root / room).is_dir():
            refused.append(f"{a.rooms.name}: there is no folder {room}")
        for other in sorted(allowed - used[room]):
            refused.append(f"{a.rooms.name}: {room} includes nothing of {other} any more: take the permission back")
    cycle = cycle_in(rooms)
    if cycle:
        refused.append(f"{a.rooms.name}: a cycle: {' -> '.join(cycle)}")
    for line in refused:
        print(line)
    print(f"{len(files)} files, {len(rooms)} rooms: " + (f"{len(refused)} refused" if refused else "every include follows the documented direction"))
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
