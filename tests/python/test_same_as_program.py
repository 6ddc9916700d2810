"""The package and the program give the same documents: one code under both."""
import csv
import json

import colift
import numpy as np
import pytest
from conftest import without_timing

POINT = (-0.45, -0.5, 1.75)


@pytest.mark.parametrize("name", ["01_office_chair_and_bottles", "07_carton_before_wall", "12_office"])
def test_look(program, frame_file, name):
    mine = colift.Setup("look").look(colift.Frame.read(str(frame_file(name)))).document()
    assert without_timing(mine) == program("look", frame_file(name))


def test_look_with_a_camera_pose(program, frame_file):
    file = frame_file("01_office_chair_and_bottles")
    angle = np.radians(122.1)  # of the optical axis from straight up, so that the floor is level
    w, x = np.cos(angle / 2), -np.sin(angle / 2)
    pose = np.eye(4)
    pose[1:3, 1:3] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    pose[:3, 3] = 0.1, 0.2, 1.0
    mine = colift.Setup("look").look(colift.Frame.read(str(file)), pose).document()
    theirs = program("look", file, f"--camera-pose=0.1,0.2,1.0,{x!r},0,0,{w!r}")
    assert mine["target"] and mine["because"] == theirs["because"]
    assert np.allclose(mine["target"]["cog"], theirs["target"]["cog"], atol=1e-6)


def test_decide(program, frame_file):
    frame = colift.Frame.read(str(frame_file("01_office_chair_and_bottles")))
    mine = colift.decide(frame, POINT, share=0.6).document()
    theirs = program("decide", frame_file("01_office_chair_and_bottles"), f"--partner={','.join(map(str, POINT))}", "--share", "0.6")
    assert without_timing(mine) == theirs


def test_decide_from_a_second_frame_and_why(program, frame_file):
    files = [frame_file("02_laptop_and_box", f"depth_{i}.png") for i in (0, 1)]
    first, second = (colift.Frame.read(str(f)) for f in files)
    outcome = colift.decide(first, second)
    theirs = program("decide", files[0], "--partner-cloud", files[1], "--why", "0")
    assert outcome.why(0) == theirs.pop("why")
    assert without_timing(outcome.document()) == theirs


def test_rank(program, tmp_path):
    problem = {"cog": [0, 0, 0], "partner": [-0.4, 0, 0], "candidates": np.array([[0.4, 0, 0], [0.2, 0, 0], [0.1, 0.5, 0]]),
               "wrenches": [[0, 0, 40, 0, 0, 0]], "weights": {"epsilon": 1, "omega1": 20, "omega2": 20}}
    file = tmp_path / "problem.json"
    file.write_text(json.dumps(problem, default=lambda v: v.tolist()))
    assert colift.rank(problem) == program("rank", file)


@pytest.mark.parametrize("scenario, seed, settings", [("pipe", 1, {"task.hold_s": 0.5})])
def test_run(program, scenario, seed, settings):
    mine = colift.run(scenario, seed=seed, settings=settings)
    said = [f"--set={path}={value}" for path, value in settings.items()]
    assert without_timing(mine) == program("run", "--scenario", scenario, "--seed", seed, *said)


def test_an_experiments_table_is_its_csv(tmp_path):
    done = colift.experiment("complex", trials=1, jobs=1, out=tmp_path)
    with open(next(tmp_path.glob("complex.csv")), newline="") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert len(rows) > 0 and list(done["trials"]) == list(rows[0])
    for column, values in done["trials"].items():
        for mine, theirs in zip(values, (row[column] for row in rows), strict=True):
            if values.dtype.kind == "f":
                assert (np.isnan(mine) and theirs == "") or mine == float(theirs)
            else:
                assert mine == theirs
    assert done["figures"] and all(len(f["interval"]) == 2 for f in done["figures"])
