"""What the package consists of: stubs that name everything, help, errors, the end of the interpreter, recordings."""
import inspect
import re
import subprocess
import sys
from pathlib import Path

import colift
import numpy as np
import pytest
from colift import _colift

STUB = (Path(colift.__file__).parent / "_colift.pyi").read_text()


def public(thing):
    return [name for name in vars(thing) if not name.startswith("_")]


def test_the_stub_names_everything_of_the_compiled_module():
    for name in public(_colift):
        assert re.search(rf"^(class|def) {name}\b|^{name}:", STUB, re.M), name
        value = getattr(_colift, name)
        if inspect.isclass(value):
            body = re.search(rf"^class {name}\b.*?(?=^\S|\Z)", STUB, re.M | re.S).group()
            for member in public(value):
                assert re.search(rf"\b{member}\b", body), f"{name}.{member}"
    assert (Path(colift.__file__).parent / "py.typed").exists()


def test_everything_public_has_help():
    for name in colift.__all__:
        thing = getattr(colift, name)
        if name == "__version__":
            continue
        assert inspect.getdoc(thing), name
        if inspect.isclass(thing):
            for member in public(thing):
                assert inspect.getdoc(inspect.getattr_static(thing, member)), f"{name}.{member}"


def test_help_names_what_people_import():
    for thing in (colift.Frame.read, colift.Frame.write, colift.PartnerGrasp.__init__, colift.Candidate.__init__):
        assert "_colift" not in thing.__doc__, thing.__doc__
    assert colift.Frame.__module__ == "colift"


def test_an_error_says_code_place_and_finding():
    with pytest.raises(colift.Error) as refused:
        colift.Setup(settings={"decision.mass_kg": -1})
    assert refused.value.code == "bad-config" and "decision.mass_kg" in str(refused.value)
    assert refused.value.where and refused.value.detail
    with pytest.raises(colift.Error) as refused:
        colift.experiment("nothing")
    assert "experiment" in refused.value.detail
    assert colift.Error("own").code == ""


def test_a_setup_reads_back():
    setup = colift.Setup(settings={"candidates.step_m": 0.02}, share=0.3)
    assert setup["candidates.step_m"] == 0.02 and setup["decision.share"] == 0.3 and "step_m" in setup.yaml()
    with pytest.raises(colift.Error):
        setup["no.such"]


def ends(script):
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_interpreter_ends_with_a_run_that_is_not_over():
    assert "begun" in ends("import colift\nrun = colift.Run(carry=lambda s: 1.0)\nrun.step()\nprint('begun')")


def test_the_interpreter_ends_while_a_daemon_thread_steps():
    assert "begun" in ends("""
import colift, threading
run = colift.Run(carry=lambda s: 1.0, grasps=lambda a: a.candidates)
began = threading.Event()
def go():
    for _ in run:
        began.set()
    while True:
        colift.synthetic_scene("table")
threading.Thread(target=go, daemon=True).start()
began.wait()
print("begun")
""")


def test_a_forked_child_leaves_its_parents_run_alone():
    assert ends("""
import colift, os
run = colift.Run()
run.step()
child = os.fork()
if child == 0:
    del run
    os._exit(0)
assert os.waitpid(child, 0)[1] == 0
assert run.step() is not None
print("both")
""").strip() == "both"


def test_a_recording_gives_the_messages_and_frames_of_its_run(tmp_path):
    from conftest import BUILD
    file = tmp_path / "run.mcap"
    document = tmp_path / "run.json"
    with open(document, "w") as out:
        subprocess.run([BUILD / "colift", "run", "--seed", "3", "--set", "task.hold_s=0.5", "--record", str(file), "--json", "--quiet"],
                       stdout=out, check=True, timeout=300)
    import json
    result = json.loads(document.read_text())
    recording = colift.Recording(file)
    assert recording.complete and recording.damage == [] and recording.duration_s > 5
    counted = {}
    last = 0.0
    for topic, t_s, message in recording.messages():
        counted[topic] = counted.get(topic, 0) + 1
        last = max(last, t_s)
        assert isinstance(message, (dict, bytes))
    assert counted == {topic: about["messages"] for topic, about in recording.topics.items() if about["messages"]}
    assert last == pytest.approx(recording.duration_s, abs=1e-6)
    frames = list(recording.frames())
    numbers = [number for number, _, _ in frames]
    assert numbers == sorted(set(numbers)) and len(frames) > 10
    assert all(frame.depth.shape == (480, 640) for _, _, frame in frames)
    assert np.isfinite(frames[-1][2].depth).mean() > 0.3
    assert result["outcome"] == "lifted" and recording.attachments
    with pytest.raises(colift.Error) as missing:
        recording.attachment("nothing")
    assert missing.value.code == "not-found"
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(file.read_bytes()[:200000])
    assert colift.Recording(cut).damage
    with pytest.raises(colift.Error):
        colift.Recording(document)


def test_a_plot_is_written_and_bad_numbers_are_refused(tmp_path):
    file = tmp_path / "plot.png"
    colift.write_plot(file, "t (s)", {"Load (N)": {"measured": ([0, 1, 2], [1, np.nan, 2]), "limit": 50.0}})
    assert file.read_bytes()[:4] == b"\x89PNG"
    for panels in ({}, {"a": {"b": ([0], [0, 1])}}, {"a": {"b": ([np.nan], [0])}}, {"a": {"b": ([0], [1e300])}}):
        with pytest.raises(colift.Error):
            colift.write_plot(file, "t (s)", panels)
    with pytest.raises(colift.Error):
        colift.write_plot("/no/where/plot.png", "t (s)", {"a": {"b": ([0, 1], [0, 1])}})
