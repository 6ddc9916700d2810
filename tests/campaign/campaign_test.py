#!/usr/bin/env python3
"""tools/campaign against one process: equal to the byte, also when a shard is killed on the way.

campaign_test.py COLIFT CAMPAIGN local|slurm
"""

import filecmp
import os
import signal
import subprocess
import sys
import tempfile
import time

import slurm_cluster

EXPERIMENT, SHARDS = "slip", 2
OPTIONS = ["--trials", "4", "--seed", "4"]
TIMEOUT_S = 200.0


def program_of_shard(shard):
    """Process of a shard, or None."""
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as f:
                words = f.read().decode(errors="replace").split("\0")
        except OSError:
            continue
        if f"{shard}/{SHARDS}" in words and EXPERIMENT in words:
            return int(pid)
    return None


def until(ready, what):
    end = time.monotonic() + TIMEOUT_S
    while not (found := ready()):
        if time.monotonic() > end:
            sys.exit(f"waited {TIMEOUT_S:.0f} s for {what}")
        time.sleep(0.05)
    return found


class Campaign:
    def __init__(self, program, script, folder, environment, *more):
        self.command = [script, EXPERIMENT, *OPTIONS, "--jobs", str(SHARDS), "--out", folder, "--timeout", "5", *more]
        self.folder = folder
        self.environment = dict(environment, COLIFT=program, CAMPAIGN_POLL_S="0.2")
        self.log = folder + ".log"

    def start(self):
        with open(self.log, "ab") as log:
            return subprocess.Popen(self.command, env=self.environment, stdout=log, stderr=log)

    def said(self):
        with open(self.log, encoding="utf-8") as f:
            return f.read()

    def row_of(self, shard):
        try:
            with open(f"{self.folder}/shards/{shard}/{EXPERIMENT}.csv", encoding="utf-8") as f:
                return any(line[0].isdigit() for line in f)
        except OSError:
            return False

    def check(self, process, code):
        if process.wait(TIMEOUT_S) != code:
            sys.exit(f"exit code {process.returncode}, expected {code}:\n{self.said()}")


def compare(one, other):
    for name in (f"{EXPERIMENT}.csv", f"{EXPERIMENT}_grasps.csv", f"{EXPERIMENT}.json"):
        if not filecmp.cmp(os.path.join(one, name), os.path.join(other, name), shallow=False):
            sys.exit(f"{name} differs from that of one process")


def killed_here(campaign):
    process = campaign.start()
    until(lambda: campaign.row_of(1), "the first row")
    os.kill(until(lambda: program_of_shard(1), "the program of shard 1"), signal.SIGKILL)
    campaign.check(process, 1)
    assert "shard 1 did not finish" in campaign.said(), campaign.said()
    campaign.check(campaign.start(), 0)


def requeued_by_slurm(campaign, cluster):
    process = campaign.start()
    until(lambda: campaign.row_of(1), "the first row")
    task = until(lambda: [w for w in campaign.said().split() if w.isdigit()], "the job's number")[0] + "_1"
    # as after the loss of a node; Slurm waits a while before it starts such a task again
    requeued = cluster.run("scontrol", "requeue", task)
    assert requeued.returncode == 0, requeued.stderr

    def runs_again():
        cluster.run("scontrol", "update", f"JobId={task}", "StartTime=now")
        return process.poll() is not None or "JobState=RUNNING" in cluster.run("scontrol", "show", "job", task).stdout

    until(runs_again, "the task to run again")
    campaign.check(process, 0)
    restarts = cluster.run("scontrol", "show", "job", task).stdout
    assert "Restarts=1" in restarts, restarts


def main():
    program, script, where = sys.argv[1:]
    if where == "slurm" and (lacking := slurm_cluster.missing()):
        print("skipped, not here:", ", ".join(lacking))
        return 77
    with tempfile.TemporaryDirectory() as folder:
        one = os.path.join(folder, "one")
        subprocess.run([program, "experiment", EXPERIMENT, *OPTIONS, "--jobs", "1", "--out", one], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=TIMEOUT_S)
        other = os.path.join(folder, "other")
        if where == "local":
            killed_here(Campaign(program, script, other, os.environ, "--local"))
        else:
            cell = os.path.join(folder, "cluster")
            os.mkdir(cell)
            with slurm_cluster.SlurmCluster(cell) as cluster:
                requeued_by_slurm(Campaign(program, script, other, cluster.env), cluster)
        compare(one, other)
    return 0


if __name__ == "__main__":
    sys.exit(main())
