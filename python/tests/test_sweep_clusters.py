"""Sweeps under Slurm and on Dask clusters, with nodes and workers that die. Some minutes: `make test-sweep` runs them.

The Slurm is one of two nodes on this machine (slurm_cluster.py)."""
from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Iterator

import pytest

from slurm_cluster import CREDENTIAL_TIME, NODE_TIMEOUT, PATH, SlurmCluster, find_missing
from sweep_tools import (FRICTION, call, check_hashes, count_frames, find_states, get_environment, get_program, make_sweep,
                         read_record, read_table, start, wait_until)

pytestmark = pytest.mark.skipif(os.environ.get("TULLE_TEST_CLUSTERS") != "1", reason="long: make test-sweep runs it")

GRID = [round(0.05 + 0.01 * i, 2) for i in range(20)]
TWO_HUNDRED = (f'friction: {{path: "cloth[0].material.friction", grid: {GRID}}}',
               f'damping: {{path: "cloth[0].material.air_damping", grid: {GRID[:10]}}}')
FOUR = 'friction: {path: "cloth[0].material.friction", grid: [0.1, 0.2, 0.3, 0.4]}'
ONE = 'friction: {path: "cloth[0].material.friction", grid: [0.1]}'
LONG = "frames: 4000"
WAIT = 4 * (NODE_TIMEOUT + CREDENTIAL_TIME) + 60  # [s] for a task to be queued again and to end
BUSY_RUN = 4  # [s] for a run of the sweep on a machine that does other things, too


@pytest.fixture(name="cluster")
def make_cluster() -> Iterator[SlurmCluster]:
    get_program()
    if find_missing():
        pytest.skip("missing: " + ", ".join(find_missing()))
    with SlurmCluster() as cluster:
        yield cluster


def get_slurm(cluster: SlurmCluster) -> dict[str, str]:
    return {"SLURM_CONF": str(cluster.conf), "PATH": PATH}


def test_two_hundred_runs_outlive_a_node(cluster: SlurmCluster, tmp_path: Path) -> None:
    path = make_sweep(tmp_path, *TWO_HUNDRED, more="frames: 30\nslurm: {time: 10, array_size: 150}")
    out = tmp_path / "out"
    child = start(path, "--engine", "slurm", **get_slurm(cluster))
    wait_until(lambda: (out / "records").exists() and find_states(out).count("whole") > 40, "the first runs")
    wait_until(lambda: bool(cluster.find_tasks("node2")), "a task on the second node")
    cluster.kill_node("node2")
    assert not cluster.find_tasks("node2")
    wait_until(lambda: "down*" in cluster.list_states(), "Slurm to give the node up", WAIT)
    said = "\n".join(child.communicate(timeout=WAIT + 200 * BUSY_RUN))
    assert child.returncode == 0, said
    assert "200 runs as Slurm jobs" in said and "200 of 200 runs whole" in said
    # The tasks of the node were queued again.
    assert any(row["attempts"] == "2" for row in read_table(out))
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


def test_a_task_whose_time_ends_goes_on_from_its_checkpoint(cluster: SlurmCluster, tmp_path: Path) -> None:
    path = make_sweep(tmp_path, ONE, more=LONG + "\nslurm: {time: 10, stop_before: 30 s}")
    out = tmp_path / "out"
    child = start(path, "--engine", "slurm", **get_slurm(cluster))
    wait_until(lambda: count_frames(out, 0) > 10, "a run")
    # The signal that Slurm sends before the limit, sent by hand: the limit itself has whole minutes.
    cluster.call(["scancel", "--batch", "--signal=USR1", *cluster.call(["squeue", "--noheader", "--format=%A"]).split()])
    wait_until(lambda: read_record(out, 0)["state"] == "interrupted", "the run to stop")
    frames = count_frames(out, 0)
    assert frames > 10 and (out / "runs" / "0000" / "checkpoint.bin").exists()
    wait_until(lambda: "PD" in cluster.call(["squeue", "--noheader", "--format=%t"]), "the task to be queued again")
    said = "\n".join(child.communicate(timeout=WAIT))
    assert child.returncode == 0, said
    assert read_table(out)[0]["attempts"] == "2"
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


def test_a_task_that_is_preempted_goes_on(cluster: SlurmCluster, tmp_path: Path) -> None:
    path = make_sweep(tmp_path, FOUR, more=LONG + "\nslurm: {partition: low, time: 10}")
    out = tmp_path / "out"
    child = start(path, "--engine", "slurm", **get_slurm(cluster))
    wait_until(lambda: all(count_frames(out, n) > 3 for n in range(4)), "four runs")
    urgent = cluster.call(["sbatch", "--parsable", "--partition=high", "--exclusive", "--nodelist=node1", "--output=/dev/null",
                           "--wrap=sleep 1"]).strip()
    wait_until(lambda: find_states(out).count("interrupted") == 2, "two runs to make room")
    wait_until(lambda: urgent not in cluster.call(["squeue", "--noheader", "--format=%A"]).split(), "the urgent job", WAIT)
    said = "\n".join(child.communicate(timeout=WAIT))
    assert child.returncode == 0, said
    assert sorted(row["attempts"] for row in read_table(out)) == ["1", "1", "2", "2"]
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


def test_ctrl_c_takes_the_jobs_back(cluster: SlurmCluster, tmp_path: Path) -> None:
    path = make_sweep(tmp_path, FRICTION, more=LONG + "\nslurm: {time: 10, throttle: 1}")
    out = tmp_path / "out"
    child = start(path, "--engine", "slurm", **get_slurm(cluster))
    wait_until(lambda: count_frames(out, 0) > 10, "a run")
    assert cluster.call(["squeue", "--noheader", "--states=running", "--format=%t"]).split() == ["R"]  # the throttle
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=60)
    assert child.returncode == 130 and find_states(out) == ["interrupted"] * 3
    assert (out / "runs" / "0000" / "checkpoint.bin").exists()
    wait_until(lambda: not cluster.call(["squeue", "--noheader"]).strip(), "an empty queue")
    # It goes on wherever one likes.
    call(path, "--engine", "local")
    assert [row["attempts"] for row in read_table(out)] == ["2", "1", "1"]
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


def test_detached_jobs_are_not_doubled(cluster: SlurmCluster, tmp_path: Path) -> None:
    folder = tmp_path / "a name with blanks"
    folder.mkdir()
    path = make_sweep(folder, FOUR, more="frames: 1500\nslurm: {time: 10}")
    out = folder / "out"
    assert "submitted: 4 runs" in call(path, "--engine", "slurm", "--detach", "--setup", "export TULLE_NOTE=1", **get_slurm(cluster))
    wait_until(lambda: count_frames(out, 0) > 3, "a run")
    assert "are in the queue" in call(path, code=2, **get_slurm(cluster))
    assert "in Slurm's queue" in call("status", out, **get_slurm(cluster))
    wait_until(lambda: find_states(out) == ["whole"] * 4, "all runs")
    call("collect", out)
    check_hashes(out, folder / "scene.yaml", folder)
    text = next((out / "slurm").glob("*.sbatch")).read_text()
    assert '#SBATCH --time="10"' in text and "#SBATCH --requeue" in text and "export TULLE_NOTE=1\n" in text


def test_what_slurm_refuses_is_told(cluster: SlurmCluster, tmp_path: Path) -> None:
    path = make_sweep(tmp_path, ONE, more="slurm: {partition: nowhere}")
    assert "invalid partition" in call(path, "--engine", "slurm", code=2, **get_slurm(cluster)).lower()


# ---- Dask ----

def test_dask_on_this_machine(tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    path = make_sweep(tmp_path, FRICTION)
    call(path, "--engine", "dask", "-j", 2)
    check_hashes(tmp_path / "out", tmp_path / "scene.yaml", tmp_path)
    assert "cannot be reached" in call(path, "--scheduler", "tcp://127.0.0.1:9", "-o", tmp_path / "other", code=2)


def test_ctrl_c_at_a_terminal_ends_the_workers_here(tmp_path: Path) -> None:
    """A terminal sends the signal to all processes of the group, the workers too."""
    pytest.importorskip("distributed")
    path = make_sweep(tmp_path, FOUR, more="frames: 3000")
    out = tmp_path / "out"
    child = start(path, "--engine", "dask", "-j", 2)
    wait_until(lambda: sum(count_frames(out, n) > 3 for n in range(4)) == 2, "two runs")
    os.killpg(child.pid, signal.SIGINT)
    said = child.communicate(timeout=60)[1]
    assert child.returncode == 130 and "Traceback" not in said, said
    assert find_states(out) == ["interrupted"] * 4
    call(path, "--engine", "local")
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


@pytest.fixture(name="scheduler")
def make_scheduler(tmp_path: Path) -> Iterator[tuple[str, list[subprocess.Popen[bytes]]]]:
    """A Dask cluster of a scheduler and two workers, each a process."""
    pytest.importorskip("distributed")
    command = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--port", "0", "--no-dashboard",
               "--scheduler-file", str(tmp_path / "scheduler.json"), "--host", "127.0.0.1"]
    worker = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(tmp_path / "scheduler.json"),
              "--no-nanny", "--nthreads", "1", "--no-dashboard", "--local-directory", str(tmp_path)]
    environment = get_environment(DASK_DISTRIBUTED__SCHEDULER__WORKER_TTL="10s")
    processes: list[subprocess.Popen[bytes]] = []
    with open(tmp_path / "dask.out", "wb") as output:
        for one in (command, worker, worker):
            processes.append(subprocess.Popen(one, env=environment, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                                              start_new_session=True))
            wait_until((tmp_path / "scheduler.json").exists, "the scheduler")
    yield json.loads((tmp_path / "scheduler.json").read_text())["address"], processes
    for process in reversed(processes):
        process.kill()
        process.wait()


def test_a_dask_worker_that_dies(scheduler: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path) -> None:
    address, processes = scheduler
    path = make_sweep(tmp_path, FOUR, more="frames: 1500")
    out = tmp_path / "out"
    child = start(path, "--scheduler", address)
    wait_until(lambda: (out / "records").exists() and find_states(out).count("running") == 2, "two runs")
    wait_until(lambda: sum(count_frames(out, n) > 3 for n in range(4)) == 2, "frames of two runs")
    processes[1].kill()
    said = "\n".join(child.communicate(timeout=WAIT))
    assert child.returncode == 0, said
    assert any(row["attempts"] == "2" for row in read_table(out))
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)


def test_ctrl_c_on_dask(scheduler: tuple[str, list[subprocess.Popen[bytes]]], tmp_path: Path) -> None:
    address, _ = scheduler
    path = make_sweep(tmp_path, FOUR, more="frames: 3000")
    out = tmp_path / "out"
    child = start(path, "--scheduler", address)
    wait_until(lambda: sum(count_frames(out, n) > 3 for n in range(4)) == 2, "two runs")
    began = time.monotonic()
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=60)
    assert child.returncode == 130 and time.monotonic() - began < 30
    assert find_states(out) == ["interrupted"] * 4 and not (out / "stop").exists()
    call(path, "--scheduler", address)
    check_hashes(out, tmp_path / "scene.yaml", tmp_path)
