"""Runs as tasks of Slurm array jobs.

A task is requeued when its node fails, when it is preempted, and when its time limit comes near: Slurm sends a signal
some time before, the run stops at a checkpoint, and the task asks to be queued again. It goes on by `--resume`."""
from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any, Optional

from .cluster import close_record, get_command
from .definition import SlurmOptions
from .execute import Stop, read_last_lines
from .layout import SweepDirectory, read_json, write_json, write_text
from .local import Report
from .problems import SweepError

POLL = 2.0           # [s] between two looks at the queue
SETTLE = 6.0         # [s] for the files of a task that has ended to be seen from here
SIGNAL = "USR1"      # comes before the time limit


def call_slurm(command: list[str]) -> subprocess.CompletedProcess[str]:
    if not shutil.which(command[0]):
        raise SweepError(f"{command[0]} is nowhere: this machine has no Slurm; runs on this machine: --engine local")
    # A session of its own: Ctrl-C at a terminal does not break it off.
    return subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace", check=False,
                          start_new_session=True)


def write_script(directory: SweepDirectory, options: SlurmOptions, threads: int, part: str, count: int) -> Path:
    """Writes the script of an array job whose tasks are the lines of slurm/PART.list."""
    folder = directory.slurm
    for name in (str(folder), *map(str, options.options.values())):
        if re.search(r'["\\\n%]' if name == str(folder) else r'["\\\n]', name):
            raise SweepError(f"{name}: may not hold quotes, backslashes or % under Slurm")
    lines = ["#!/bin/bash", "# An array job of a sweep: each task makes one run, or goes on with it.",
             *(f"#SBATCH --{name}" if value is True else f'#SBATCH --{name}="{value}"' for name, value in options.options.items())]
    if "job-name" not in options.options:
        lines.append("#SBATCH --job-name=tulle-sweep")
    throttle = f"%{options.throttle}" if options.throttle else ""
    lines += [f"#SBATCH --array=0-{count - 1}{throttle}", f"#SBATCH --cpus-per-task={threads}", "#SBATCH --requeue",
              "#SBATCH --open-mode=append", f"#SBATCH --signal=B:{SIGNAL}@{options.stop_before}",
              f'#SBATCH --output="{folder}/{part}.%a.txt"', *options.setup,
              f'number=$(sed -n "$((SLURM_ARRAY_TASK_ID + 1))p" {shlex.quote(str(folder / (part + ".list")))})',
              # exec: the signal goes to the process that the script has become.
              "exec " + shlex.join(get_command(directory)) + ' "$number"']
    script = folder / f"{part}.sbatch"
    write_text(script, "\n".join(lines) + "\n")
    return script


def submit(directory: SweepDirectory, numbers: list[int], options: SlurmOptions, threads: int) -> dict[str, Any]:
    """Submits the runs, and notes the jobs in slurm/jobs.json: of each its number and its runs."""
    directory.slurm.mkdir(exist_ok=True)
    jobs: dict[str, Any] = {}
    stamp = time.strftime("%Y%m%dT%H%M%S")
    for at in range(0, len(numbers), options.array_size):
        chunk = numbers[at:at + options.array_size]
        part = f"{stamp}.{at // options.array_size}"
        write_text(directory.slurm / f"{part}.list", "".join(f"{number}\n" for number in chunk))
        script = write_script(directory, options, threads, part, len(chunk))
        done = call_slurm(["sbatch", "--parsable", str(script)])
        if done.returncode != 0:
            if jobs:
                cancel(jobs)
            raise SweepError(f"sbatch {script}: {' '.join(done.stderr.split()) or 'refused'}")
        jobs[done.stdout.strip().split(";")[0]] = {"part": part, "runs": chunk}
        write_json(directory.slurm / "jobs.json", jobs)
    return jobs


def find_queued(jobs: dict[str, Any]) -> Optional[set[str]]:
    """Which of the jobs are still in the queue; None where Slurm does not answer."""
    queued = set()
    for job in jobs:
        done = call_slurm(["squeue", "--noheader", "--jobs", job, "--format", "%A"])
        if done.returncode == 0 and done.stdout.strip():
            queued.add(job)
        elif done.returncode != 0 and "Invalid job id" not in done.stderr:
            return None
    return queued


def cancel(jobs: dict[str, Any]) -> None:
    """Takes the jobs out of the queue; runs stop at a checkpoint."""
    call_slurm(["scancel", *jobs])


def get_jobs_in_queue(directory: SweepDirectory) -> list[str]:
    """Jobs of an earlier call that still wait or run, where there is a Slurm to ask."""
    jobs = read_json(directory.slurm / "jobs.json")
    if not isinstance(jobs, dict) or not jobs or not shutil.which("squeue"):
        return []
    return sorted(find_queued(jobs) or ())


def watch(directory: SweepDirectory, jobs: dict[str, Any], stop: Stop, report: Report) -> None:
    """Waits until all jobs have left the queue, and reports the runs as they end. A wish to stop cancels the jobs."""
    waiting = {number: job for job, facts in jobs.items() for number in facts["runs"]}
    is_cancelled = False
    empty_since: Optional[float] = None
    while waiting:
        if is_cancelled:
            time.sleep(POLL)
        else:
            stop.changed.wait(POLL)
        if stop.level and not is_cancelled:
            cancel(jobs)
            is_cancelled = True
        report_ended(directory, waiting, report)
        queued = find_queued(jobs)
        if queued is None or queued:
            empty_since = None
            if stop.level > 1:
                break
        elif empty_since is None:
            empty_since = time.monotonic()
        elif time.monotonic() - empty_since > SETTLE or is_cancelled:
            break
    for number, job in waiting.items():
        part, runs = jobs[job]["part"], jobs[job]["runs"]
        said = read_last_lines(directory.slurm / f"{part}.{runs.index(number)}.txt", 0)
        report(close_record(directory, number, stop.reason or f"its task of job {job} left the queue without a result", said))


def report_ended(directory: SweepDirectory, waiting: dict[int, str], report: Report) -> None:
    for number in list(waiting):
        record = directory.read_record(number)
        if record and record["state"] in ("whole", "failed"):
            del waiting[number]
            report(record)


def requeue() -> bool:
    """Asks Slurm to queue the task that this process is in again; whether it will."""
    job = os.environ.get("SLURM_JOB_ID", "")
    return bool(job) and call_slurm(["scontrol", "requeue", job]).returncode == 0
