#!/usr/bin/env python3
"""Shows that a change of structure changed no result.

    same_results.py record PROGRAM FOLDER [--short]     lifts, recordings and experiment tables of a program
    same_results.py compare PROGRAM FOLDER [--short]    the same lifts with another build, compared with FOLDER

Lifts: table, box, pipe, chair, and a table that is heavy on one side with test lifts; both methods; three seeds each.
Experiments: tilt, load, complex, six trials. Compared are

- every number of the run's document but computing times, exactly;
- every state change: its time and its name;
- status, decision and plan of the recorded lift, replayed by the other build (`colift log replay`), bit for bit;
- the experiments' tables, byte for byte.

Words (reasons, messages) may be changed by a change of wording: they are counted and shown, and end in 1 only with --words.
Floating-point results depend on compiler and libraries, so FOLDER belongs to one machine and is not kept in the repository.
Ends with 0 when everything is the same, 1 otherwise, 2 when it was called wrongly.
"""
import argparse, concurrent.futures, json, os, pathlib, subprocess, sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENARIOS = {
    "table": [], "box": [], "pipe": [], "chair": [],
    "table_heavy_side": ["--set", "test_lift.on=true"],
}
METHODS = ["fast", "thesis"]
SEEDS = [1, 2, 3]
EXPERIMENTS = ["tilt", "load", "complex"]
# what a wall clock measured, and what says so
TIMES = {"wall_s", "decision_compute_ms", "monitor_ms", "plan_ms", "timing_ms", "total_ms", "compute_ms"}


def lifts(short):
    for scenario, options in SCENARIOS.items():
        for method in METHODS:
            for seed in SEEDS[:1] if short else SEEDS:
                yield f"{scenario}-{method}-{seed}", [
                    "run", "--scenario", str(ROOT / "config/scenario" / f"{scenario}.yaml"), "--method", method,
                    "--seed", str(seed), *options]


def call(program, arguments, timeout=900):
    done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=timeout)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(arguments)}: exit {done.returncode}: {done.stderr.strip()[-500:]}")
    return done


def leaves(value, path=""):
    """Every number, text and null of a document with its place."""
    if isinstance(value, dict):
        for key, entry in value.items():
            if key not in TIMES:
                yield from leaves(entry, f"{path}.{key}")
    elif isinstance(value, list):
        yield f"{path}.length", len(value)
        for i, entry in enumerate(value):
            yield from leaves(entry, f"{path}[{i}]")
    else:
        yield path, value


def one_lift(program, name, arguments, folder, record):
    extra = ["--record", str(folder / f"{name}.mcap")] if record else []
    return json.loads(call(program, [*arguments, "--json", *extra]).stdout)


def differences(old, new):
    """(numbers that differ, words that differ); keys that only the new document has are free to be added."""
    mine = dict(leaves(new))
    numbers, words = [], []
    for place, value in leaves(old):
        if place not in mine:
            numbers.append(f"{place}: {value!r} is gone")
        elif mine[place] != value:
            is_word = isinstance(value, str) and isinstance(mine[place], str)
            exact = place.endswith((".state", ".outcome", ".schema", ".phase"))
            (words if is_word and not exact else numbers).append(f"{place}: {value!r} became {mine[place]!r}")
    return numbers, words


def only_words(difference):
    """Whether two replayed messages differ in texts alone (the document lists the first hundred)."""
    if isinstance(difference, list):
        return all(only_words(entry["differs"]) for entry in difference)
    if set(difference) == {"recorded", "replayed"}:
        return isinstance(difference["recorded"], str) and isinstance(difference["replayed"], str)
    return all(only_words(entry) for entry in difference.values())


def experiment(program, name, out):
    call(program, ["experiment", name, "--trials", "6", "--out", str(out)], timeout=3600)


def record(program, folder, short, jobs):
    folder.mkdir(parents=True, exist_ok=True)

    def work(item):
        name, arguments = item
        document = one_lift(program, name, arguments, folder, record=True)
        (folder / f"{name}.json").write_text(json.dumps(document))
        return f"{name}: {document['outcome']}"

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for line in pool.map(work, lifts(short)):
            print(line, flush=True)
        if not short:
            for _ in pool.map(lambda e: experiment(program, e, folder / "experiments"), EXPERIMENTS):
                pass
    return 0


def compare(program, folder, short, jobs, judge_words):
    bad = reworded = 0

    def work(item):
        name, arguments = item
        lines, words = [], []
        old = json.loads((folder / f"{name}.json").read_text())
        numbers, words = differences(old, one_lift(program, name, arguments, folder, record=False))
        lines += numbers
        replay = subprocess.run([program, "log", "replay", str(folder / f"{name}.mcap"), "--json"],
                                capture_output=True, text=True, timeout=900)
        if replay.returncode == 1 and replay.stdout:
            for part in json.loads(replay.stdout)["differences"]:
                where = f"replay {part['topic']} {part['index']}"
                (words if only_words(part["differs"]) else lines).append(f"{where}: {json.dumps(part['differs'])[:300]}")
        elif replay.returncode != 0:
            lines.append(f"replay: exit {replay.returncode}: {(replay.stderr or replay.stdout).strip()[:600]}")
        return name, lines, words

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for name, lines, words in pool.map(work, lifts(short)):
            print(f"{name}: {'same' if not lines else 'DIFFERENT'}" + (f", {len(words)} reworded" if words else ""), flush=True)
            for line in lines[:12] + (words[:4] if judge_words else []):
                print("   ", line)
            bad += bool(lines)
            reworded += len(words)
        if not short:
            out = folder / "experiments_again"
            subprocess.run(["rm", "-rf", str(out)], check=True)
            for _ in pool.map(lambda e: experiment(program, e, out), EXPERIMENTS):
                pass
            for name in EXPERIMENTS:
                same = (folder / "experiments" / f"{name}.csv").read_bytes() == (out / f"{name}.csv").read_bytes()
                print(f"{name}.csv: {'same' if same else 'DIFFERENT'}")
                bad += not same
    print(f"{'all the same' if not bad else f'{bad} differ'}; {reworded} texts reworded")
    return 1 if bad or (judge_words and reworded) else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["record", "compare"])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--short", action="store_true", help="one seed, no experiments")
    parser.add_argument("--words", action="store_true", help="a text that changed is a difference, too")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    a = parser.parse_args()
    program = str(a.program.resolve())
    if a.what == "record":
        return record(program, a.folder, a.short, a.jobs)
    return compare(program, a.folder, a.short, a.jobs, a.words)


if __name__ == "__main__":
    sys.exit(main())
