"""CoLift from Python: a robot that carries something large together with a person.

    import colift
    scene = colift.synthetic_scene("table", seed=22)
    analysis = colift.look(scene["frame"], camera_pose=scene["camera_pose"])
    outcome = analysis.decide(scene["frame_with_partner"])
    print(outcome.reason)

    result = colift.run("pipe", seed=3)
    print(result["outcome"], result["lift"])

Units are m, rad, N, N m, kg and s. W is the robot's base frame, z up, when the camera's pose is known; else it is the
camera's own optical frame (x right, y down, z forward). Documents that are returned as dicts are those that the program
prints with --json (`colift schema NAME` describes them); they come from the same code. What CoLift cannot do is an
`Error`. Long computations let other Python threads run.
"""

from __future__ import annotations

import json
import operator
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache
from os import PathLike
from typing import Any

import numpy as np

from . import _colift
from ._colift import Candidate, Error, Frame, PartnerGrasp, Status, __version__

__all__ = ["Analysis", "Candidate", "Error", "Frame", "Outcome", "PartnerGrasp", "Recording", "Run", "Setup", "Status", "decide",
           "experiment", "experiments", "look", "rank", "run", "scenarios", "synthetic_scene", "write_plot", "__version__"]

File = str | PathLike[str]


def _settings(settings: Mapping[str, Any] | None) -> list[str]:
    def text(value: Any) -> str:
        if value is None:
            return "~"
        if isinstance(value, float) and not np.isfinite(value):
            return ".nan" if np.isnan(value) else (".inf" if value > 0 else "-.inf")
        return json.dumps(value.tolist() if hasattr(value, "tolist") else value)

    return [f"{path}={text(value)}" for path, value in (settings or {}).items()]


def _text(value: float | None) -> str:
    return "" if value is None else repr(float(value))


def _numbers(value: Any) -> Any:
    return None if value is None else np.asarray(value, dtype=float)


def _index(said: Any) -> int | None:
    if said is not None and operator.index(said) < 0:
        raise IndexError(f"the choice is {said}; indices of candidates begin at 0")
    return None if said is None else operator.index(said)


def _write(compiled: Any, picture: File | None, report: File | None) -> None:
    compiled.write(None if picture is None else str(picture), None if report is None else str(report))


class Setup:
    """A configuration, checked once and used for many frames.

    `command`: whose defaults, "decide", "look" or "run". `method`: "fast" or "thesis". `share`: part of the load that the
    robot shall carry, 0 to 1. `settings`: {"candidates.step_m": 0.02}, as --set. `config_files`: as --config.
    Raises Error (bad-config) with the entry and what was expected.
    """

    def __init__(self, command: str = "decide", *, method: str = "", share: float | None = None, share_strict: float | None = None,
                 settings: Mapping[str, Any] | None = None, config_files: Sequence[File] = ()):
        self._c = _colift.Setup(command, method, _text(share), _text(share_strict), _settings(settings), [str(f) for f in config_files])

    @property
    def method(self) -> str:
        """"fast" or "thesis"."""
        return self._c.method

    @property
    def warnings(self) -> list[str]:
        """What was accepted and should be looked at, such as old names of entries."""
        return self._c.warnings

    def yaml(self, explain: bool = False) -> str:
        """Every entry with its value and who said it; with `explain` also meaning, range and unit."""
        return self._c.yaml(explain)

    def __getitem__(self, path: str) -> Any:
        """The value of an entry, "decision.weights.epsilon"; None where it is unset."""
        text = self._c.text_of(path)
        special = {"~": None, ".inf": np.inf, "-.inf": -np.inf, ".nan": np.nan}
        if text in special:
            return special[text]
        try:
            return json.loads(text)
        except json.JSONDecodeError:
            return text

    def look(self, frame: Frame, camera_pose: Any = None, at: Any = None,
             grasps: Callable[[Analysis], Sequence[Candidate]] | None = None) -> Analysis:
        """Finds ground, object, its faces and grasp candidates in a depth frame.

        `camera_pose`: X_WF, 4 x 4, from the frame's own axes to W; None: unknown. `at`: a point (W, m) that picks the object there
        instead of the largest. `grasps`: your generator; what it returns stands in place of CoLift's candidates, each judged for
        collision and stability. No ground or no object is a finding, not an error: `Analysis.reason` says why.
        """
        analysis = Analysis(self._c.look(frame, _numbers(camera_pose), _numbers(at)))
        if grasps is not None and analysis.cog is not None:
            analysis.candidates = list(grasps(analysis))
        return analysis


class Analysis:
    """What one look at a frame found. `document()` is colift.look/1."""

    def __init__(self, compiled: Any):
        self._c = compiled

    def document(self) -> dict[str, Any]:
        """As `colift look --json`."""
        return json.loads(self._c.json_text)

    @property
    def reason(self) -> str:
        """One sentence: the candidates, or why there is no object."""
        return self._c.reason

    @property
    def depth(self) -> np.ndarray:
        """The depth image that was analysed, height x width float32 (m); a read-only view, not a copy."""
        return self._c.depth

    @property
    def ground(self) -> tuple[np.ndarray, float] | None:
        """Normal n, upwards, and offset d (m) of the plane n . p + d = 0 in W; None where no ground was found."""
        return self._c.ground

    @property
    def points(self) -> np.ndarray | None:
        """Visible points of the object, n x 3 float32 (W, m); a read-only view, not a copy. None without an object."""
        return self._c.points

    @property
    def pixels(self) -> np.ndarray | None:
        """Its pixels as indices into the flat image, ascending; a read-only view. Empty with the method "thesis"."""
        return self._c.pixels

    @property
    def cog(self) -> np.ndarray | None:
        """Estimated centre of gravity (W, m)."""
        return self._c.cog

    @property
    def candidates(self) -> list[Candidate]:
        """Grasp candidates with their verdicts. Assign a list to decide among your own: each is judged for collision and
        stability, and none are added around the optimum."""
        return self._c.candidates

    @candidates.setter
    def candidates(self, candidates: Sequence[Candidate]) -> None:
        self._c.candidates = list(candidates)

    def judge(self, candidate: Candidate) -> Candidate:
        """A candidate with its verdict, as if it were one of CoLift's."""
        return self._c.judge(candidate)

    def decide(self, partner: Any, *, setup: Setup | None = None, choice: Callable[[Outcome], int | None] | None = None) -> Outcome:
        """Decides where the robot takes hold.

        `partner`: where he holds the object: a point (W, m), a PartnerGrasp, a second Frame of the same camera in which he is
        found, or a callable that gets this analysis and returns one of these. `setup`: other weights and limits. `choice`: your
        rule; gets the Outcome and returns the index of the candidate that is taken, or None for CoLift's choice; it is not asked
        where nothing is feasible. Raises Error (bad-input) for an estimate that is none and for a choice that is not feasible.
        """
        if callable(partner):
            partner = partner(self)
        if not isinstance(partner, (Frame, PartnerGrasp)):
            partner = _numbers(partner)
        outcome = Outcome(self._c.decide(partner, setup._c if setup else None))
        if choice is not None and outcome.chosen is not None:
            index = _index(choice(outcome))
            if index is not None and index != outcome.chosen:
                mine = outcome.candidates[outcome.chosen].id
                outcome._c.choose_instead(index, f"the caller's choice in place of candidate {mine}")
        return outcome

    def write(self, picture: File | None = None, report: File | None = None) -> None:
        """Writes what was seen as a PNG and as an HTML page, as `colift look --png --report`."""
        _write(self._c, picture, report)


class Outcome:
    """A decision with every candidate's verdict. `document()` is colift.decide/1."""

    def __init__(self, compiled: Any):
        self._c = compiled

    def document(self) -> dict[str, Any]:
        """As `colift decide --json`."""
        return json.loads(self._c.json_text)

    @property
    def reason(self) -> str:
        """Why this grasp, or why none."""
        return self._c.reason

    @property
    def partner(self) -> PartnerGrasp | None:
        """Where he holds the object, with covariance; None: nobody was found, `partner_reason` says why."""
        return self._c.partner

    @property
    def partner_reason(self) -> str:
        """How his grasp is known, or why it is not."""
        return self._c.partner_reason

    @property
    def candidates(self) -> list[Candidate]:
        """Those of the analysis, and some around the closed-form optimum."""
        return self._c.candidates

    @property
    def chosen(self) -> int | None:
        """Index into `candidates`."""
        return self._c.chosen

    @property
    def costs(self) -> np.ndarray:
        """Effort of both for a lift (N^2), by candidate; NaN where none can be computed."""
        return self._c.costs

    @property
    def shares(self) -> np.ndarray:
        """The robot's share of the load by the lever rule, 0 to 1, by candidate."""
        return self._c.shares

    def why(self, id: int) -> dict[str, Any]:
        """Why this candidate was or was not chosen, as "why" of `colift decide --why`: its cost by terms (N^2), its rank among
        the possible ones, and "text", all of it in sentences. `id`: Candidate.id. Raises Error (bad-input) with the ids that there are."""
        return json.loads(self._c.why_text(id))

    def write(self, picture: File | None = None, report: File | None = None) -> None:
        """Writes the decision as a PNG and as an HTML page, as `colift decide --png --report`."""
        _write(self._c, picture, report)


@lru_cache(maxsize=16)
def _made(method: str, share: float | None, settings: tuple[tuple[str, str], ...]) -> Setup:
    return Setup("decide", method=method, share=share, settings={path: json.loads(text) for path, text in settings})


def _setup(method: str, share: float | None, settings: Mapping[str, Any] | None) -> Setup:
    entries = ((path, json.dumps(value.tolist() if hasattr(value, "tolist") else value)) for path, value in (settings or {}).items())
    return _made(method, share, tuple(entries))


def look(frame: Frame, camera_pose: Any = None, *, at: Any = None, method: str = "", settings: Mapping[str, Any] | None = None,
         grasps: Callable[[Analysis], Sequence[Candidate]] | None = None) -> Analysis:
    """Setup("decide", ...).look(...) in one call; the last 16 setups are kept."""
    return _setup(method, None, settings).look(frame, camera_pose, at, grasps)


def decide(frame: Frame, partner: Any, camera_pose: Any = None, *, share: float | None = None, method: str = "",
           settings: Mapping[str, Any] | None = None) -> Outcome:
    """look() and Analysis.decide() in one call."""
    return _setup(method, share, settings).look(frame, camera_pose).decide(partner)


def rank(problem: Mapping[str, Any]) -> dict[str, Any]:
    """Which of several places carries a task best, on numbers alone: documents of `colift rank` in and out
    (`colift schema rank-problem`, `colift schema rank`); arrays may be NumPy's. Raises Error (bad-input) with the place."""
    return json.loads(_colift.rank(json.dumps(problem, default=lambda value: value.tolist())))


class Run:
    """One whole job on the simulated rig, step by step: each step goes on to the next status, 30 a second of the robot's time.

        run = colift.Run("table", seed=2)
        for status in run:
            print(status.t_s, status.state, status.height_m)
        print(run.result["outcome"])

    `scenario`: a shipped name (`scenarios()`) or a file; None: the built-in table. `rig`: "imperfect" for the faults of real
    sensors. `share`, `share_strict`, `dry_run`, `settings`, `config_files`: as the options of `colift run`.

    Your part of the job, each may be None. They are called from a thread of the job while a step runs, one at a time. What one of
    them raises ends the job by a controlled stop and is raised from the last step.

    `grasps(analysis)`: the candidates of the scene, in place of `analysis.candidates`; each is judged for collision, stability and
    reach.
    `partner(analysis, seen)`: where he holds the object, in place of the camera's estimate: a PartnerGrasp or a point (W, m).
    `choice(outcome)`: index of the candidate to take, or None for CoLift's choice. One that is not feasible ends the decision.
    `carry(sample)`: once for each frame while the object is raised and held; gets a dict (t_s, state, palm_height_m,
    object_rise_m, tilt_rad, slip_m, load_n, force_W, torque_W, palm_W) and returns the speed scale of the palm, 0 to 1, or a
    pair of it and whether the hold is over.
    `lower_confirmed()`, `continue_confirmed()`: whether a person confirms that a paused object may be lowered; that an arm which
    stopped for somebody may continue (`monitor.resume`). Asked in every cycle of the job; where nothing waits for it, True has no
    effect.

    A run that is not needed any more is ended by close(), at the end of a `with`, or when nothing refers to it: by a controlled
    stop, without another call of your callables.
    """

    def __init__(self, scenario: str | None = None, *, method: str = "", seed: int = 1, share: float | None = None,
                 share_strict: float | None = None, rig: str | None = None, dry_run: bool = False,
                 settings: Mapping[str, Any] | None = None, config_files: Sequence[File] = (),
                 grasps: Callable[[Analysis], Sequence[Candidate]] | None = None,
                 partner: Callable[[Analysis, PartnerGrasp], Any] | None = None,
                 choice: Callable[[Outcome], int | None] | None = None,
                 carry: Callable[[dict[str, Any]], Any] | None = None, lower_confirmed: Callable[[], bool] | None = None,
                 continue_confirmed: Callable[[], bool] | None = None):
        def own_grasps(analysis: Any) -> list[Candidate]:
            return list(grasps(Analysis(analysis)))

        def own_partner(analysis: Any, seen: PartnerGrasp) -> PartnerGrasp:
            said = partner(Analysis(analysis), seen)
            return said if isinstance(said, PartnerGrasp) else PartnerGrasp(_numbers(said))

        def own_choice(outcome: Any) -> int | None:
            return _index(choice(Outcome(outcome)))

        def own_carry(sample: dict[str, Any]) -> tuple[float, bool]:
            said = carry(sample)
            return (float(said[0]), bool(said[1])) if isinstance(said, tuple) else (float(said), False)

        self._c = _colift.Run(None if scenario is None else str(scenario), method, seed, _text(share), _text(share_strict),
                              None if rig is None else str(rig), dry_run, _settings(settings), [str(f) for f in config_files],
                              grasps and own_grasps, partner and own_partner, choice and own_choice, carry and own_carry,
                              lower_confirmed and (lambda: bool(lower_confirmed())),
                              continue_confirmed and (lambda: bool(continue_confirmed())))

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __iter__(self) -> Iterator[Status]:
        while (status := self.step()) is not None:
            yield status

    def step(self) -> Status | None:
        """Goes on to the next status; None when the job is over. Ctrl-C is raised after the step; then call stop() and step on, or
        close(). Raises Error (not-ready) where another thread steps the same run."""
        return self._c.step()

    def stop(self) -> None:
        """Asks for a controlled stop; the steps go on until the arm is at rest."""
        self._c.stop()

    def close(self) -> None:
        """Ends the job by a controlled stop, if it is not over, and waits for it."""
        self._c.close()

    @property
    def over(self) -> bool:
        """Whether the job has ended."""
        return self._c.over

    @property
    def result(self) -> dict[str, Any]:
        """As `colift run --json`. Raises Error (not-ready) before the job is over."""
        return json.loads(self._c.json_text)

    def write_report(self, file: File) -> None:
        """The page that `colift run --report` writes."""
        self._c.write_report(str(file))

    def write_picture(self, file: File) -> None:
        """The picture of the lift, as `--png`."""
        self._c.write_picture(str(file))


def run(scenario: str | None = None, **options: Any) -> dict[str, Any]:
    """A whole job on the simulated rig; options as of Run. As `colift run --json`."""
    with Run(scenario, **options) as job:
        for _ in job:
            pass
        return job.result


class Recording:
    """A recording of `colift run --record` (MCAP); damaged ones are read as far as they go.

    `topics`: {topic: {"messages", "encoding", "schema"}}. `damage`: what is wrong, one sentence each.
    """

    def __init__(self, file: File):
        self._c = _colift.Recording(str(file))
        info = self._c.info
        self.topics: dict[str, dict[str, Any]] = info["topics"]
        self.attachments: list[str] = info["attachments"]
        self.damage: list[str] = info["damage"]
        self.complete: bool = info["complete"]
        self.start_ns: int = info["start_ns"]
        self.duration_s: float = 1e-9 * (info["end_ns"] - info["start_ns"])

    def messages(self, *topics: str) -> Iterator[tuple[str, float, Any]]:
        """Topic, time since the start (s) and message, in the order of the file; JSON messages as dicts, others as bytes. All
        topics when none is named."""
        for topic, time_ns, data, encoding in self._c.messages(set(topics)):
            yield topic, 1e-9 * (time_ns - self.start_ns), json.loads(data) if encoding == "json" else data

    def frames(self) -> Iterator[tuple[int, float, Frame]]:
        """Number, time since the start (s) and depth frame, decoded to the bit."""
        for number, time_ns, frame in self._c.frames():
            yield number, 1e-9 * (time_ns - self.start_ns), frame

    def attachment(self, name: str) -> bytes:
        """Of `attachments`, such as the run's configuration. Raises Error (not-found)."""
        return self._c.attachment(name)


def _column(texts: list[str]) -> np.ndarray:
    try:
        return np.array([float(t) if t else np.nan for t in texts])
    except ValueError:
        return np.array(texts)


def experiment(name: str, trials: int = 0, *, seed: int = 1, method: str = "fast", jobs: int = 0, out: File | None = None,
               progress: Callable[[int, int, str], None] | None = None) -> dict[str, Any]:
    """An experiment of the thesis, or one beyond it, as tables: "trials" and "details" by column (arrays; NaN where a cell is
    empty), "figures" with their 95 % intervals. `trials` 0: its own number. `out`: folder of the tables, where an earlier call
    is continued; None: a temporary one. `progress(done, of, words)`. Ctrl-C ends it after the trials that run."""
    with tempfile.TemporaryDirectory() as folder:
        done = _colift.experiment(name, trials, seed, method, jobs, str(out or folder), progress)
    for table in ("trials", "details"):
        done[table] = {column: _column(texts) for column, texts in done[table].items()}
    return done


def experiments() -> list[tuple[str, str, str]]:
    """Name, title and question of each experiment."""
    return _colift.experiments()


def scenarios() -> list[tuple[str, str, str]]:
    """Name, file and description of each shipped scenario."""
    return _colift.scenarios()


def synthetic_scene(kind: str = "table", seed: int = 1, *, two_hands: bool = False) -> dict[str, Any]:
    """A room with a "table", "box" or "pipe" as a Kinect would see it: "frame", "frame_with_partner", "camera_pose" (4 x 4),
    and the truth: "contact" of the partner's hand and "cog" of the object (W, m). The same seed gives the same bits."""
    return _colift.synthetic_scene(kind, seed, two_hands)


def write_plot(file: File, x_title: str, panels: Mapping[str, Mapping[str, Any]]) -> None:
    """Draws line plots one above the other as a PNG. `panels`: {"Load (N)": {"measured": (x, y), "limit": 50.0}}: pairs of equally
    long sequences are curves (NaN in y leaves a gap), numbers are levels. Raises Error (bad-input)."""
    def floats(values: Any) -> list[float]:
        return [float(v) for v in values]

    drawn = []
    for title, entries in panels.items():
        curves = [(name, floats(e[0]), floats(e[1])) for name, e in entries.items() if not np.isscalar(e)]
        levels = [(name, float(e)) for name, e in entries.items() if np.isscalar(e)]
        drawn.append((title, curves, levels))
    _colift.write_plot(str(file), x_title, drawn)
