"""A Slurm cluster of some nodes on this machine, in a temporary folder: munged, slurmctld and a slurmd for each node.

It uses ports, sockets and files of its own, so it is in no way of a Slurm that the machine may have. Nodes differ by
their ports (`slurmd -N NAME`). A node can be killed with all that runs on it, as a power cut would, and started again.

usage: slurm_cluster.py COMMAND...      runs a command beside such a cluster; SLURM_CONF leads to it"""
from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, Optional

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel", "sinfo")
START_TIME = 60.0     # [s] for the nodes to be idle
NODE_TIMEOUT = 10     # [s] after which a silent node counts as down
CREDENTIAL_TIME = 10  # [s] that a task's credential holds; a task that was requeued starts after it
QUIET_ROUNDS = 5      # looks without a task after which a node is dead
PATH = os.pathsep.join(("/usr/sbin", "/usr/local/sbin", os.environ.get("PATH", "")))


def find_missing() -> list[str]:
    """The programs that a cluster needs and that are not there, and whether one may start it."""
    missing = [name for name in PROGRAMS if not shutil.which(name, path=PATH)]
    return missing or ([] if os.geteuid() == 0 else ["the rights of root"])


def find_free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class SlurmCluster:
    """Use it with `with`. `conf` is its slurm.conf, to be handed on as SLURM_CONF."""

    def __init__(self, node_count: int = 2, cpus: int = 2) -> None:
        self.folder = Path(tempfile.mkdtemp(prefix="slurm."))
        self.conf = self.folder / "slurm.conf"
        self.nodes = [f"node{i + 1}" for i in range(node_count)]
        self.cpus = cpus
        self.daemons: dict[str, subprocess.Popen[bytes]] = {}
        self.environment = dict(os.environ, SLURM_CONF=str(self.conf), PATH=PATH)

    def __enter__(self) -> SlurmCluster:
        try:
            self.write_files()
            self.start_daemon("munged", ["munged", "--foreground", "--force", f"--key-file={self.folder}/munge.key",
                                         f"--socket={self.folder}/munge.socket", f"--pid-file={self.folder}/munge.pid",
                                         f"--log-file={self.folder}/munge.log", f"--seed-file={self.folder}/munge.seed"])
            self.wait_until(lambda: (self.folder / "munge.socket").exists(), "munged's socket")
            self.start_daemon("slurmctld", ["slurmctld", "-D"])
            for node in self.nodes:
                self.start_node(node)
            self.wait_until(lambda: self.list_states() == ["idle"] * len(self.nodes), "all nodes to be idle")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.call(["scancel", "--user=root"])
        for node in self.nodes:
            self.kill_node(node)
        for name in ("slurmctld", "munged"):
            daemon = self.daemons.pop(name, None)
            if daemon:
                daemon.terminate()
                try:
                    daemon.wait(10)
                except subprocess.TimeoutExpired:
                    daemon.kill()
                    daemon.wait()
        shutil.rmtree(self.folder, ignore_errors=True)

    def write_files(self) -> None:
        folder, host = self.folder, socket.gethostname().split(".")[0]
        (folder / "state").mkdir()
        (folder / "munge.key").write_bytes(os.urandom(1024))
        (folder / "munge.key").chmod(0o400)
        ports = find_free_ports(1 + len(self.nodes))
        lines = [
            "ClusterName=tulletest", f"SlurmctldHost={host}(127.0.0.1)", f"SlurmctldPort={ports[0]}",
            "SlurmUser=root", "SlurmdUser=root", "AuthType=auth/munge",
            f"AuthInfo=socket={folder}/munge.socket,cred_expire={CREDENTIAL_TIME}",
            f"StateSaveLocation={folder}/state", f"SlurmdSpoolDir={folder}/spool.%n",
            f"SlurmctldPidFile={folder}/slurmctld.pid", f"SlurmdPidFile={folder}/slurmd.%n.pid",
            f"SlurmctldLogFile={folder}/slurmctld.log", f"SlurmdLogFile={folder}/slurmd.%n.log",
            "ProctrackType=proctrack/linuxproc", "TaskPlugin=task/none", "MpiDefault=none",
            "SchedulerType=sched/backfill", "SchedulerParameters=sched_interval=2,bf_interval=2",
            "SelectType=select/cons_tres", "SelectTypeParameters=CR_CPU", "SlurmdParameters=config_overrides",
            "PreemptType=preempt/partition_prio", "PreemptMode=REQUEUE", "ReturnToService=2", f"SlurmdTimeout={NODE_TIMEOUT}",
            "KillWait=20"]
        lines += [f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={self.cpus} State=UNKNOWN"
                  for node, port in zip(self.nodes, ports[1:])]
        lines += ["PartitionName=low Nodes=ALL Default=YES MaxTime=INFINITE State=UP PriorityTier=1",
                  "PartitionName=high Nodes=ALL MaxTime=INFINITE State=UP PriorityTier=10 PreemptMode=OFF"]
        self.conf.write_text("\n".join(lines) + "\n", encoding="utf-8")

    def start_daemon(self, name: str, command: list[str]) -> None:
        with open(self.folder / f"{name}.out", "ab") as output:
            self.daemons[name] = subprocess.Popen(command, env=self.environment, stdin=subprocess.DEVNULL, stdout=output,
                                                  stderr=subprocess.STDOUT, start_new_session=True)

    def start_node(self, node: str) -> None:
        self.start_daemon(node, ["slurmd", "-D", "-N", node])

    def kill_node(self, node: str) -> None:
        """Kills the daemon of a node, then the keepers of its tasks, then the tasks: nobody is left to tell of it."""
        daemon = self.daemons.pop(node, None)
        if daemon:
            daemon.kill()
            daemon.wait()
        # A keeper that was just starting shows its task a moment later.
        quiet_rounds = 0
        while quiet_rounds < QUIET_ROUNDS:
            tasks = self.find_tasks(node)
            quiet_rounds = 0 if tasks else quiet_rounds + 1
            keepers = {parent for task in tasks for parent in [get_parent(task)] if get_name(parent) == "slurmstepd"}
            for process in [*keepers, *tasks]:
                try:
                    os.kill(process, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            time.sleep(0.1)

    def find_tasks(self, node: str) -> list[int]:
        """The processes of the jobs on a node. They are ours: their environment names our slurm.conf and the node."""
        marks = {f"SLURMD_NODENAME={node}".encode(), f"SLURM_CONF={self.conf}".encode()}
        found = []
        for path in Path("/proc").glob("[0-9]*/environ"):
            try:
                if marks <= set(path.read_bytes().split(b"\0")):
                    found.append(int(path.parent.name))
            except OSError:
                continue
        return found

    def call(self, command: list[str]) -> str:
        """What a program of Slurm prints."""
        done = subprocess.run(command, env=self.environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
        return done.stdout

    def list_states(self) -> list[str]:
        return self.call(["sinfo", "--noheader", "--Node", "--partition=low", "--format=%t"]).split()

    def wait_until(self, is_so: Any, what: str, seconds: float = START_TIME) -> None:
        """Waits, or fails with the ends of the logs."""
        end = time.monotonic() + seconds
        while not is_so():
            if time.monotonic() > end:
                logs = "\n".join(f"--- {path.name}\n{path.read_text(errors='replace')[-1500:]}" for path in self.folder.glob("*.log"))
                raise TimeoutError(f"waited {seconds:g} s for {what}\n{logs}")
            time.sleep(0.2)


def read_stat(process: int) -> Optional[tuple[str, int]]:
    """Name and parent of a process."""
    try:
        text = Path(f"/proc/{process}/stat").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None
    head, _, rest = text.rpartition(")")
    return head.partition("(")[2], int(rest.split()[1])


def get_name(process: int) -> str:
    return (read_stat(process) or ("", 0))[0]


def get_parent(process: int) -> int:
    return (read_stat(process) or ("", 0))[1]


if __name__ == "__main__":
    if find_missing():
        sys.exit("slurm_cluster.py: missing: " + ", ".join(find_missing()))
    with SlurmCluster() as cluster:
        sys.exit(subprocess.run(sys.argv[1:] or ["sinfo"], env=cluster.environment, check=False).returncode)
