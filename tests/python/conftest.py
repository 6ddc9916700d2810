"""What the tests share: the program beside the package, recorded frames, documents without what a clock says."""
import json
import os
import subprocess
from pathlib import Path

import pytest

BUILD = Path(os.environ["COLIFT_BUILD"])
DATA = Path(__file__).parents[1] / "data"
TIMING = {"timing", "timing_ms"}


def without_timing(value):
    if isinstance(value, dict):
        return {key: without_timing(v) for key, v in value.items() if key not in TIMING}
    return [without_timing(v) for v in value] if isinstance(value, list) else value


@pytest.fixture(scope="session")
def program():
    """Runs colift with arguments; its document, without times."""
    def run(*arguments, stdin=None):
        done = subprocess.run([BUILD / "colift", *map(str, arguments), "--json"], input=stdin, capture_output=True, text=True,
                              timeout=300)
        assert done.stdout, done.stderr
        return without_timing(json.loads(done.stdout))
    return run


@pytest.fixture(scope="session")
def scene():
    import colift
    return colift.synthetic_scene("table", seed=22)


@pytest.fixture(scope="session")
def analysis(scene):
    import colift
    return colift.look(scene["frame"], scene["camera_pose"])


@pytest.fixture
def frame_file():
    return lambda name, file="depth.png": DATA / "real" / name / file
