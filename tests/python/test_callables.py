"""Own grasps, partner, choice and carrying are used, checked like CoLift's own, and their exceptions arrive."""
import threading
import time

import colift
import numpy as np
import pytest

QUICK = {"task.hold_s": 0.5}


def stepped(**options):
    with colift.Run("table", settings=QUICK, **options) as run:
        states = [status.state for status in run]
        return run.result, states


def copy(c, **changes):
    fields = {name: getattr(c, name) for name in ("position", "approach", "closing", "width", "depth_m")} | changes
    return colift.Candidate(**fields)


def test_own_grasps_stand_in_place_of_colifts(scene, analysis):
    mine = [copy(c) for c in analysis.candidates if c.verdict == "ok"][:3]
    found = colift.look(scene["frame"], scene["camera_pose"], grasps=lambda a: mine)
    outcome = found.decide(scene["contact"])
    assert [c.id for c in outcome.candidates] == [0, 1, 2]
    assert outcome.chosen is not None and outcome.candidates[outcome.chosen].verdict == "chosen"


def test_analyses_and_outcomes_keep_their_candidates(scene):
    found = colift.look(scene["frame"], scene["camera_pose"])
    outcome = found.decide(scene["contact"])
    before = outcome.document()
    found.candidates = []
    assert outcome.document() == before and found.candidates == []


@pytest.mark.parametrize("changes, reason", [
    ({"closing": (1, 0, 0), "approach": (1, 0, 0)}, "perpendicular"),
    ({"approach": (2, 0, 0)}, "unit"),
    ({"position": (np.nan, 0, 0)}, "finite"),
    ({"position": (1e30, 0, 0)}, "away"),
    ({"width": -1.0}, "width"),
    ({"depth_m": np.inf}, "finite"),
])
def test_what_is_no_grasp_is_refused_with_a_reason(scene, analysis, changes, reason):
    judged = analysis.judge(copy(analysis.candidates[0], **changes))
    assert judged.verdict == "unreachable" and reason in judged.reason
    found = colift.look(scene["frame"], scene["camera_pose"], grasps=lambda a: [copy(a.candidates[0], **changes)])
    assert found.decide(scene["contact"]).chosen is None


@pytest.mark.parametrize("partner", [
    (np.nan, 0, 0), colift.PartnerGrasp((0, np.inf, 0)), colift.PartnerGrasp((1, 0, 0), -np.eye(3)),
    colift.PartnerGrasp((1, 0, 0), [[1, 5, 0], [0, 1, 0], [0, 0, 1]]), colift.PartnerGrasp((1, 0, 0), np.full((3, 3), np.nan)),
])
def test_an_estimate_that_is_none_is_refused(analysis, partner):
    with pytest.raises(colift.Error) as refused:
        analysis.decide(partner)
    assert refused.value.code == "bad-input" and refused.value.where == "partner"


def test_a_choice_is_taken_and_an_infeasible_one_refused(scene, analysis):
    second = lambda outcome: int(np.argsort([outcome.costs[i] if c.verdict in ("ok", "chosen") else np.inf
                                             for i, c in enumerate(outcome.candidates)])[1])
    outcome = analysis.decide(scene["contact"], choice=second)
    assert outcome.candidates[outcome.chosen].verdict == "chosen" and "caller's choice" in outcome.reason
    assert outcome.document()["decision"]["candidate"] == outcome.candidates[outcome.chosen].id
    collides = next(i for i, c in enumerate(outcome.candidates) if c.verdict not in ("ok", "chosen"))
    with pytest.raises(colift.Error, match="not feasible"):
        analysis.decide(scene["contact"], choice=lambda o: collides)
    with pytest.raises(colift.Error, match="candidates"):
        analysis.decide(scene["contact"], choice=lambda o: 10**6)
    with pytest.raises(IndexError):
        analysis.decide(scene["contact"], choice=lambda o: -1)


def test_a_run_uses_all_of_them():
    asked = {}
    carried = []

    def grasps(analysis):
        asked["points"] = analysis.points.shape
        return [c for c in analysis.candidates]

    def partner(analysis, seen):
        asked["seen"] = seen.position
        return colift.PartnerGrasp(seen.position + (0, 0.001, 0), seen.covariance)

    def choice(outcome):
        assert np.allclose(outcome.partner.position, asked["seen"] + (0, 0.001, 0))
        feasible = [i for i, c in enumerate(outcome.candidates) if c.verdict in ("ok", "chosen")]
        asked["choice"] = sorted(feasible, key=lambda i: outcome.costs[i])[-1 if len(feasible) < 2 else 1]
        return asked["choice"]

    def carry(sample):
        carried.append(sample)
        return 0.5, sample["t_s"] > carried[0]["t_s"] + 4.0

    result, states = stepped(grasps=grasps, partner=partner, choice=choice, carry=carry)
    assert asked["points"][1] == 3 and "choice" in asked
    assert "caller's choice" in result["decision"]["because"]
    assert carried and "lift" in states
    slowest = result["monitor"]["min_speed_scale"]
    assert slowest is not None and slowest <= 0.5


def test_who_confirms_lets_an_arm_continue_that_has_stopped():
    with colift.Run("person_in_the_path", settings={"monitor.resume": False},
                    continue_confirmed=lambda: doing.startswith("waits for confirmation")) as run:
        doing, asked = "", 0
        for status in run:
            doing = status.doing
            asked += doing.startswith("waits for confirmation")
        assert run.result["outcome"] == "lifted"
    assert 1 <= asked < 10  # confirmed as soon as it is asked for


def test_a_run_that_cannot_use_them_says_why():
    result, _ = stepped(partner=lambda analysis, seen: (np.nan, 0, 0))
    assert result["outcome"] != "lifted" and "covariance" in result["states"][-1]["because"] + result["because"] + str(result["states"])
    result, _ = stepped(choice=lambda outcome: next(i for i, c in enumerate(outcome.candidates) if c.verdict == "collision"))
    assert result["outcome"] != "lifted" and "not feasible" in result["because"] + str(result["states"])


@pytest.mark.parametrize("where, what", [("grasps", KeyError("mine")), ("choice", KeyError("mine")), ("carry", KeyboardInterrupt())])
def test_what_a_callable_raises_ends_the_job_and_arrives(where, what):
    def fails(*_):
        raise what

    run = colift.Run("table", settings=QUICK, **{where: fails})
    with pytest.raises(type(what)):
        for _ in run:
            pass
    assert run.over and run.step() is None
    assert run.result["outcome"] != "lifted"


def test_another_type_of_answer_is_a_type_error():
    run = colift.Run("table", settings=QUICK, grasps=lambda analysis: [1, 2])
    with pytest.raises(TypeError):
        for _ in run:
            pass


def test_stop_ends_a_run_and_close_ends_it_at_once():
    run = colift.Run("table")
    with pytest.raises(colift.Error) as early:
        run.result
    assert early.value.code == "not-ready"
    while run.step().state != "approach":
        pass
    run.stop()
    rest = [status.state for status in run]
    assert rest and run.over and run.result["outcome"] != "lifted"

    called = []
    run = colift.Run("table", carry=lambda sample: called.append(1) or 1.0)
    while run.step().state != "lift":
        pass
    before = len(called)
    run.close()
    assert run.over and len(called) == before and run.result["outcome"] != "lifted"


def test_two_runs_step_by_turns_as_alone():
    dry = {"dry_run": True}
    alone = [colift.run("table", seed=seed, **dry) for seed in (2, 3)]
    runs = [colift.Run("table", seed=seed, **dry) for seed in (2, 3)]
    while any([run.step() is not None for run in runs]):
        pass
    assert [without(run.result) for run in runs] == [without(result) for result in alone]


def without(result):
    return {key: value for key, value in result.items() if key != "timing"}


def test_one_thread_steps_a_run():
    run = colift.Run("table", settings=QUICK, grasps=lambda analysis: run.step() or analysis.candidates)
    with pytest.raises(colift.Error, match="inside of a step"):
        for _ in run:
            pass


def test_other_threads_go_on_while_a_frame_is_analysed(scene):
    setup = colift.Setup()
    counted, end = [0], threading.Event()

    def count():
        while not end.is_set():
            counted[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    longest = 0
    for _ in range(5):
        before = counted[0]
        setup.look(scene["frame"], scene["camera_pose"])
        longest = max(longest, counted[0] - before)
    end.set()
    thread.join()
    assert longest > 10  # a call that keeps the interpreter's lock lets nobody count
