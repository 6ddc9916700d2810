#!/usr/bin/env python3
"""tools/campaign alone: a stand-in for the program writes one row a shard, stand-ins for Slurm's commands answer as told.

script_test.py CAMPAIGN [NAME...]
"""

import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

TIMEOUT_S = 60.0

# A shard's row; with the file `hold` it waits for `go`, or to be ended; with `fail.I` shard I fails.
PROGRAM = """#!/bin/sh
here=$(dirname "$0")
printf '%s\\n' "$*" >>"$here/calls"
if [ "$2" = merge ]; then
  shift 2
  while [ "$1" != --out ]; do cat "$1/slip.csv" >>"$here/merged" || exit 1; shift; done
  mv "$here/merged" "$2/slip.csv"; exit
fi
for word; do case $before in --shard) shard=${word%/*} ;; --out) out=$word ;; esac; before=$word; done
[ ! -e "$here/fail.$shard" ] || { echo "no such thing"; exit 2; }
mkdir "$here/runs.$shard" || { : >"$here/twice"; exit 1; }
trap 'sleep 0.3; : >"$here/ended.$shard"; rmdir "$here/runs.$shard"; exit 130' TERM
while [ -e "$here/hold" ] && [ ! -e "$here/go" ]; do sleep 0.02; done
mkdir -p "$out"; echo "$shard,fast" >"$out/slip.csv"
rmdir "$here/runs.$shard"
"""


def until(ready, what):
    end = time.monotonic() + TIMEOUT_S
    while not ready():
        assert time.monotonic() < end, f"waited {TIMEOUT_S:.0f} s for {what}"
        time.sleep(0.02)


class Place:
    def __init__(self, script, folder):
        self.script = script
        self.folder = pathlib.Path(folder)
        self.out = self.folder / "a folder" / "out"
        (self.folder / "bin").mkdir()
        self.executable("program", PROGRAM)
        self.env = dict(os.environ, COLIFT=str(self.folder / "program"), CAMPAIGN_POLL_S="0.05",
                        PATH=f"{self.folder}/bin:{os.environ['PATH']}")

    def executable(self, name, text):
        (self.folder / name).write_text(text)
        (self.folder / name).chmod(0o755)

    def touch(self, name):
        (self.folder / name).touch()

    def there(self, name):
        return (self.folder / name).exists()

    def start(self, *words):
        return subprocess.Popen([self.script, *words, "--out", self.out], env=self.env, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def call(self, code, *words):
        process = self.start(*words)
        said = process.communicate(timeout=TIMEOUT_S)[0]
        assert process.returncode == code, f"exit code {process.returncode}, expected {code}: {said}"
        return said

    def calls(self):
        return (self.folder / "calls").read_text().splitlines()

    def merged(self):
        return (self.out / "slip.csv").read_text()


LOCAL = ("slip", "--jobs", "2", "--local")


def options_reach_the_program_and_nothing_else(place):
    place.call(0, *LOCAL)
    shards = place.out / "shards"
    assert sorted(place.calls()[:2]) == [
        f"experiment slip --jobs 1 --shard {i}/2 --out {shards}/{i}" for i in (1, 2)], place.calls()
    assert place.merged() == "1,fast\n2,fast\n"


def order_of_options_does_not_matter(place):
    place.call(0, *LOCAL, "--seed=4", "--trials", "9")
    place.call(0, *LOCAL, "--trials", "9", "--seed", "4")
    assert "--trials 9 --seed 4 --shard" in place.calls()[0]


def another_campaign_is_refused(place):
    place.call(0, *LOCAL)
    for other in ((*LOCAL, "--seed", "2"), ("slip", "--jobs", "3", "--local"), ("tilt", "--jobs", "2", "--local")):
        assert "belongs to another campaign: experiment slip" in place.call(2, *other)


def tables_of_somebody_else_are_kept(place):
    place.out.mkdir(parents=True)
    (place.out / "slip.csv").write_text("hours of work\n")
    assert "choose another --out" in place.call(2, *LOCAL)
    assert place.merged() == "hours of work\n"


def wrong_calls_are_named(place):
    assert "--quiet is not known" in place.call(2, *LOCAL, "--quiet", "--trials", "9")
    assert "--trials needs a value" in place.call(2, *LOCAL, "--trials", "--seed", "9")
    assert "--jobs expects" in place.call(2, "slip", "--jobs", "0")
    assert not place.out.exists()


def shard_that_fails_is_named_with_its_log(place):
    place.touch("fail.2")
    said = place.call(1, *LOCAL)
    assert f"shard 2 did not finish: no such thing ({place.out}/shards/2.log)" in said, said
    assert "1 of 2 shards" in said and not (place.out / "slip.csv").exists()
    (place.folder / "fail.2").unlink()
    place.call(0, *LOCAL)
    assert place.merged() == "1,fast\n2,fast\n"


def held(place, *words):
    """A call whose shards run and wait."""
    place.touch("hold")
    process = place.start(*words)
    until(lambda: place.there("runs.1") and place.there("runs.2"), "both shards")
    return process


def interrupted_call_waits_for_its_trials(place):
    process = held(place, *LOCAL)
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=TIMEOUT_S)[0]
    assert process.returncode == 130 and "the same command continues" in said, said
    assert place.there("ended.1") and place.there("ended.2")
    place.touch("go")
    place.call(0, *LOCAL)


def shard_runs_once_at_a_time(place):
    first = held(place, *LOCAL)
    first.kill()  # its shards go on
    first.wait()
    second = place.start(*LOCAL)
    until(lambda: waiting(place.out / "shards/1.lock") and waiting(place.out / "shards/2.lock"), "shards that wait")
    place.touch("go")
    said = second.communicate(timeout=TIMEOUT_S)[0]
    assert second.returncode == 0 and not place.there("twice"), said
    first.stdout.close()


def waiting(lock):
    """Whether a flock waits for this file."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as f:
                if f.read().startswith(b"flock\0") and os.readlink(f"/proc/{pid}/fd/9") == str(lock):
                    return True
        except OSError:
            pass
    return False


def cluster(place, sinfo="exit 0"):
    """Slurm whose controller does not answer the first question about the job; then the tasks run, and it has forgotten them."""
    for name in ("sinfo", "sbatch", "squeue", "scancel"):
        (place.folder / "bin" / name).unlink(missing_ok=True)
    here = place.folder
    place.executable("bin/sinfo", f"#!/bin/sh\n{sinfo}\n")
    place.executable("bin/sbatch", f"""#!/bin/sh
for word; do case $word in --wrap=*) echo "${{word#--wrap=}}" >"{here}/wrap" ;; --array=*) echo "$word" >"{here}/array" ;; esac; done
echo '7;test'
""")
    place.executable("bin/squeue", f"""#!/bin/sh
[ -e "{here}/asked" ] || {{ : >"{here}/asked"; echo "slurm_load_jobs error: Unable to contact slurm controller" >&2; exit 1; }}
[ -e "{here}/wrap" ] || {{ echo "slurm_load_jobs error: Invalid job id specified" >&2; exit 1; }}
for i in 1 2; do SLURM_ARRAY_TASK_ID=$i sh "{here}/wrap" >&2; done
rm "{here}/wrap"
echo COMPLETING
""")


def silent_controller_is_not_the_end_of_a_job(place):
    cluster(place)
    said = place.call(0, "slip", "--jobs", "2")
    assert "Slurm array 7 of 2 tasks" in said, said
    assert (place.folder / "array").read_text() == "--array=1-2\n"
    assert place.merged() == "1,fast\n2,fast\n"


def cluster_that_does_not_answer_is_named(place):
    cluster(place, "echo 'sinfo: error: no controller' >&2; exit 1")
    said = place.call(0, "slip", "--jobs", "2")
    assert "no cluster answers: sinfo: error: no controller" in said and "2 processes" in said, said


TESTS = [options_reach_the_program_and_nothing_else, order_of_options_does_not_matter, another_campaign_is_refused,
         tables_of_somebody_else_are_kept, wrong_calls_are_named, shard_that_fails_is_named_with_its_log,
         interrupted_call_waits_for_its_trials, shard_runs_once_at_a_time, silent_controller_is_not_the_end_of_a_job,
         cluster_that_does_not_answer_is_named]


def main():
    script, wanted, failed = sys.argv[1], sys.argv[2:], 0
    for test in TESTS:
        if wanted and test.__name__ not in wanted:
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                test(Place(script, os.path.realpath(folder)))
                print("passed:", test.__name__, flush=True)
            except (AssertionError, subprocess.TimeoutExpired) as e:
                failed += 1
                print(f"FAILED: {test.__name__}: {e}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
