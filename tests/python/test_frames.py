"""Frames and points are views of what CoLift holds; what is no frame is refused with a reason, and nothing crashes."""
import gc

import colift
import numpy as np
import pytest


def depth(height=480, width=640):
    return np.full((height, width), 2.0, dtype=np.float32)


def test_depth_is_a_view_and_not_a_copy(scene):
    frame = scene["frame"]
    assert np.shares_memory(frame.depth, frame.depth)
    assert frame.depth.shape == (480, 640) and frame.depth.dtype == np.float32


def test_points_and_pixels_are_views(analysis):
    assert np.shares_memory(analysis.points, analysis.points)
    assert np.shares_memory(analysis.pixels, analysis.pixels)
    assert analysis.points.shape == (analysis.pixels.size, 3)


def test_a_view_keeps_its_owner_alive(scene):
    analysis = colift.look(scene["frame"], scene["camera_pose"])
    points, copy = analysis.points, analysis.points.copy()
    analysis.candidates = []  # what the points belong to is replaced
    del analysis
    gc.collect()
    assert np.array_equal(points, copy)
    frame = colift.Frame(depth())
    image = frame.depth
    del frame
    gc.collect()
    assert np.all(image == 2.0)


def test_a_view_cannot_be_written(scene, analysis):
    for view in (scene["frame"].depth, analysis.points, analysis.pixels):
        with pytest.raises(ValueError):
            view[0] = 0
        with pytest.raises(ValueError):
            view.setflags(write=True)


def test_a_frame_keeps_what_it_is_made_of():
    image = depth(6, 8).astype(np.float64)[::2, ::2]  # not contiguous
    image[0, 0] = -1
    frame = colift.Frame(image, intrinsics=(10, 10, 2, 1.5), rgb=np.zeros((3, 4, 3), np.uint8), up=(0, -1, 0))
    assert np.isnan(frame.depth[0, 0]) and frame.depth[1, 1] == 2.0
    assert frame.intrinsics == (10, 10, 2, 1.5) and frame.rgb.shape == (3, 4, 3)


def test_a_written_frame_reads_back_to_the_millimetre(tmp_path, scene):
    scene["frame"].write(str(tmp_path / "frame.png"))
    back = colift.Frame.read(str(tmp_path / "frame.png"))
    assert back.intrinsics == pytest.approx(scene["frame"].intrinsics)
    assert np.array_equal(np.isnan(back.depth), np.isnan(scene["frame"].depth))
    assert np.nanmax(np.abs(back.depth - scene["frame"].depth)) <= 0.000501


def test_a_shipped_frame_is_found_by_its_name():
    assert np.isfinite(colift.Frame.read("01_office_chair_and_bottles").depth).mean() > 0.5
    with pytest.raises(colift.Error, match="did you mean"):
        colift.Frame.read("01_office_chair")


@pytest.mark.parametrize("make, where", [
    (lambda: colift.Frame(depth().astype(np.uint16)), "depth"),
    (lambda: colift.Frame(depth().astype(complex)), "depth"),
    (lambda: colift.Frame(depth().ravel()), "depth"),
    (lambda: colift.Frame(np.zeros((0, 640), np.float32)), "depth"),
    (lambda: colift.Frame(1000 * depth()), "depth"),
    (lambda: colift.Frame(np.broadcast_to(np.float32(1), (100000, 100000))), "depth"),
    (lambda: colift.Frame(depth(48, 64)), "intrinsics"),
    (lambda: colift.Frame(depth(), intrinsics=(0, 500, 320, 240)), "intrinsics"),
    (lambda: colift.Frame(depth(), intrinsics=(500, np.nan, 320, 240)), "intrinsics"),
    (lambda: colift.Frame(depth(), intrinsics=(500, 500, 9e9, 240)), "intrinsics"),
    (lambda: colift.Frame(depth(), rgb=np.zeros((480, 640), np.uint8)), "rgb"),
    (lambda: colift.Frame(depth(), rgb=np.zeros((480, 640, 3), np.int8)), "rgb"),
    (lambda: colift.Frame(depth(), up=(0, 0, np.inf)), "up"),
    (lambda: colift.Frame.read("/nowhere.png"), "/nowhere.png"),
])
def test_what_is_no_frame_is_refused(make, where):
    with pytest.raises(colift.Error) as refused:
        make()
    assert refused.value.code in ("bad-input", "not-found") and where in refused.value.where
    assert refused.value.detail and str(refused.value) == f"{refused.value.where}: {refused.value.detail}"


@pytest.mark.parametrize("pose", [np.full((4, 4), np.nan), 2 * np.eye(4), np.diag([1, 1, -1, 1]), 1e9 * np.ones((4, 4)),
                                  np.block([[np.eye(3), np.full((3, 1), 1e9)], [np.zeros((1, 3)), 1]])])
def test_a_pose_that_is_none_is_refused(scene, pose):
    with pytest.raises(colift.Error, match="camera_pose"):
        colift.look(scene["frame"], pose)


@pytest.mark.parametrize("call", [
    lambda s: colift.look(s["frame"], np.eye(3)),
    lambda s: colift.look(s["frame"], s["camera_pose"], at=(1, 2)),
    lambda s: colift.look(s["frame"].depth),
    lambda s: colift.decide(s["frame"], "left", s["camera_pose"]),
    lambda s: colift.Run(seed=-1),
])
def test_another_type_is_a_type_error(scene, call):
    with pytest.raises((TypeError, ValueError)):
        call(scene)


def test_random_frames_end_with_a_finding_or_a_reason():
    random = np.random.default_rng(7)
    for _ in range(60):
        height, width = (int(n) for n in random.integers(1, 60, 2))
        image = random.choice([np.nan, np.inf, -1.0, 0.0, 1e-30, 0.4, 3.0, 99.0], (height, width))
        if random.random() < 0.5:
            image = random.uniform(0.3, 5.0) + 0.01 * random.standard_normal((height, width))
        k = (random.choice([1.0, 50.0, 1e5]), random.choice([1.0, 50.0, 1e5]), width / 2, random.uniform(0, height))
        pose = np.eye(4)
        pose[:3, 3] = random.uniform(-500, 500, 3)
        up = (0.0, -1.0, 0.0) if random.random() < 0.5 else None
        try:
            found = colift.look(colift.Frame(image, k, up=up), pose if random.random() < 0.5 else None)
            outcome = found.decide(random.choice([0.0, 1e3 - 1, -5.0], 3))
            assert found.reason and outcome.reason and outcome.document()["schema"] == "colift.decide/1"
        except colift.Error as refused:
            assert refused.code and refused.detail


def test_random_settings_end_with_a_setup_or_a_reason():
    random = np.random.default_rng(8)
    names = ["candidates.step_m", "decision.mass_kg", "decision.weights.epsilon", "target.min_confidence", "", "a.b", "task.hold_s"]
    for _ in range(60):
        value = random.choice(np.array([np.nan, np.inf, -1, 0, 1e308, "x", "[", None, True], dtype=object))
        try:
            colift.Setup(random.choice(["look", "decide", "run", "x"]), settings={random.choice(names): value})
        except colift.Error as refused:
            assert refused.code in ("bad-config", "bad-input") and refused.detail
