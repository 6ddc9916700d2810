"""A Slurm cluster of this machine alone, in a folder of its own, for the time of a test.

Needs the packages slurm-wlm and munge, and root (slurmd drops to the user of a job). Daemons listen on free ports; no cgroups.
"""

import os
import shutil
import socket
import subprocess
import time

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "sinfo", "squeue", "scontrol")
START_TIMEOUT_S = 30.0


def missing():
    """Programs that are not installed; also says so when nobody may start daemons."""
    lacking = [p for p in PROGRAMS if shutil.which(p, path=os.environ["PATH"] + ":/usr/sbin:/sbin") is None]
    if os.geteuid() != 0:
        lacking.append("root")
    return lacking


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class SlurmCluster:
    def __init__(self, folder):
        self.folder = folder
        self.daemons = []
        self.host = socket.gethostname().split(".")[0]
        self.env = dict(os.environ, SLURM_CONF=self.path("slurm.conf"),
                        PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")

    def path(self, name):
        return os.path.join(self.folder, name)

    def __enter__(self):
        os.chmod(self.folder, 0o755)
        for name in ("state", "spool", "munge"):
            os.mkdir(self.path(name), 0o755)
        with open(self.path("munge/key"), "wb") as f:
            f.write(os.urandom(1024))
        os.chmod(self.path("munge/key"), 0o400)
        with open(self.path("slurm.conf"), "w", encoding="utf-8") as f:
            f.write(self.configuration())
        with open(self.path("cgroup.conf"), "w", encoding="utf-8") as f:
            f.write("CgroupAutomount=no\n")
        munge = self.path("munge")
        self.start("munged", "--foreground", "--force", f"--socket={munge}/socket", f"--key-file={munge}/key",
                   f"--pid-file={munge}/pid", f"--log-file={munge}/log", f"--seed-file={munge}/seed")
        self.wait(lambda: os.path.exists(f"{munge}/socket"), "munged")
        self.start("slurmctld", "-D", "-f", self.path("slurm.conf"))
        self.start("slurmd", "-D", "-N", self.host, "-f", self.path("slurm.conf"))
        self.wait(lambda: "idle" in self.run("sinfo", "-h", "-o", "%T").stdout, "the node")
        return self

    def configuration(self):
        f = self.folder
        return "\n".join((
            "ClusterName=test", f"SlurmctldHost={self.host}(127.0.0.1)", "AuthType=auth/munge",
            f"AuthInfo=socket={f}/munge/socket", "CredType=cred/munge", "SlurmUser=root", "SlurmdUser=root",
            f"SlurmctldPort={free_port()}", f"SlurmdPort={free_port()}", f"StateSaveLocation={f}/state",
            f"SlurmdSpoolDir={f}/spool", f"SlurmctldPidFile={f}/slurmctld.pid", f"SlurmdPidFile={f}/slurmd.pid",
            f"SlurmctldLogFile={f}/slurmctld.log", f"SlurmdLogFile={f}/slurmd.log", "ProctrackType=proctrack/pgid",
            "TaskPlugin=task/none", "SelectType=select/cons_tres", "ReturnToService=2", "MpiDefault=none",
            "JobRequeue=1", "SchedulerParameters=sched_interval=1,batch_sched_delay=0", "InactiveLimit=0", "KillWait=2",
            f"NodeName={self.host} NodeAddr=127.0.0.1 CPUs={os.cpu_count()} State=UNKNOWN",
            "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP", ""))

    def start(self, *command):
        with open(self.path(command[0] + ".out"), "ab") as log:
            self.daemons.append(subprocess.Popen(command, env=self.env, stdout=log, stderr=log))

    def run(self, *command):
        return subprocess.run(command, env=self.env, capture_output=True, text=True, timeout=30, check=False)

    def wait(self, ready, what):
        end = time.monotonic() + START_TIMEOUT_S
        while not ready():
            dead = [d.args[0] for d in self.daemons if d.poll() is not None]
            if dead or time.monotonic() > end:
                raise RuntimeError(f"{what} did not come up in {START_TIMEOUT_S:.0f} s; ended: {dead}; {self.logs()}")
            time.sleep(0.1)

    def logs(self):
        text = ""
        for name in ("munged.out", "slurmctld.out", "slurmd.out", "slurmctld.log", "slurmd.log"):
            if os.path.exists(self.path(name)):
                with open(self.path(name), encoding="utf-8", errors="replace") as f:
                    text += f"\n--- {name}\n" + f.read()[-1500:]
        return text

    def __exit__(self, *unused):
        self.run("scancel", "-u", "root")
        for daemon in reversed(self.daemons):
            daemon.terminate()
        for daemon in self.daemons:
            try:
                daemon.wait(10)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()
