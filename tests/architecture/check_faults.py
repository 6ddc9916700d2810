#!/usr/bin/env python3
"""The check of the includes has to see each fault: small trees that are wrong in one way each, and one that is right."""
import pathlib, subprocess, sys, tempfile

CHECK = pathlib.Path(__file__).resolve().parent / "check_includes.py"
ROOMS = "hal:\nperception: hal\n"
RIGHT = {"hal/arm.hpp": "#pragma once\n", "perception/scene.cpp": '#include "hal/arm.hpp"\n'}

# what is added to the right tree, the table, and the words of the refusal
FAULTS = [
    ({"hal/driver.cpp": '#include "perception/scene.hpp"\n', "perception/scene.hpp": ""}, ROOMS, "hal may not include perception"),
    ({"perception/look.cpp": '#include "hal/hand.hpp"\n'}, ROOMS, "there is no hal/hand.hpp"),
    ({"hal/driver.cpp": '#include "perception/scene.hpp"\n', "perception/scene.hpp": ""}, "hal: perception\nperception: hal\n", "a cycle"),
    ({"perception/look.cpp": "#include <pcl/point_types.h>\n"}, ROOMS, "<pcl/point_types.h> belongs in"),
    ({"planner/plan.cpp": ""}, ROOMS, "has no line"),
    ({}, ROOMS + "planner:\n", "there is no folder planner"),
    ({"planner/plan.cpp": ""}, ROOMS + "planner: hal\n", "take the permission back"),
    ({"hal/long.cpp": "\n" * 441}, ROOMS, "441 lines"),
    ({f"hal/file_{i}.cpp": "" for i in range(24)}, ROOMS, "25 source files"),
]


def run(files, rooms):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in files.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        (root / "rooms.txt").write_text(rooms)
        done = subprocess.run([sys.executable, CHECK, "--root", root, "--rooms", root / "rooms.txt"], capture_output=True, text=True)
        return done.returncode, done.stdout


def main():
    code, said = run(RIGHT, ROOMS)
    wrong = [] if code == 0 else [f"refuses a tree that is right:\n{said}"]
    for more, rooms, words in FAULTS:
        code, said = run({**RIGHT, **more}, rooms)
        if code == 0 or words not in said:
            wrong.append(f"does not say '{words}' (exit code {code}):\n{said}")
    print("\n".join(wrong) or f"{len(FAULTS)} faults, each of them seen")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
